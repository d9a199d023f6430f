# XXH64 with seed 0, which .vxs files have of each section. Numbers wrap at 64 bits.
# SPDX-License-Identifier: MIT
extends Object

const A = -7046029288634856825
const B = -4417276706812531889
const C = 1609587929392839161
const D = -8796714831421723037
const E = 2870177450012600261


static func of(bytes: PackedByteArray) -> int:
	var size := bytes.size()
	var at := 0
	var hash := E
	if size >= 32:
		var lanes := PackedInt64Array([A + B, B, 0, -A])
		while at + 32 <= size:
			for n in 4:
				var sum := lanes[n] + bytes.decode_s64(at) * B
				lanes[n] = (sum << 31 | (sum >> 33 & 0x7fffffff)) * A
				at += 8
		hash = _turned(lanes[0], 1) + _turned(lanes[1], 7) + _turned(lanes[2], 12) + _turned(lanes[3], 18)
		for lane in lanes:
			hash = (hash ^ _turned(lane * B, 31) * A) * A + D
	hash += size
	while at + 8 <= size:
		hash = _turned(hash ^ _turned(bytes.decode_s64(at) * B, 31) * A, 27) * A + D
		at += 8
	if at + 4 <= size:
		hash = _turned(hash ^ bytes.decode_u32(at) * A, 23) * B + C
		at += 4
	while at < size:
		hash = _turned(hash ^ bytes[at] * E, 11) * A
		at += 1
	hash = (hash ^ _down(hash, 33)) * B
	hash = (hash ^ _down(hash, 29)) * C
	return hash ^ _down(hash, 32)


static func _turned(x: int, by: int) -> int:
	return x << by | _down(x, 64 - by)


static func _down(x: int, by: int) -> int:
	return x >> by & ((1 << (64 - by)) - 1)
