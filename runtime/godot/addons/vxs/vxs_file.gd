# Reads a .vxs file of palette blocks packed fast (formats/vxs.md, 14.10), whose pages are frames of zstd, which Godot has. Rules of
# patterns are not checked: `vxs validate` does that.
# SPDX-License-Identifier: MIT
extends RefCounted

const RECORD = 256
const PRIVATE_HALVES = [0, 0, 0, 19, 33, 65, 97, 3, 6, 6, 10]
const MOST = 4096 # bytes of a frame for one of the file: a damaged one cannot ask for all memory
const Hash = preload("vxs_hash.gd")
const DAMAGED = "the file is damaged"

var names := PackedStringArray()
var constants := PackedByteArray()
var words := PackedByteArray()

var _page := PackedInt32Array()
var _half := 0 # where the next new pattern of the page starts


## Fill names, constants and words. Returns an error, or "".
func read(bytes: PackedByteArray) -> String:
	if bytes.size() < 64 or bytes.slice(0, 8) != PackedByteArray([0x8f, 0x56, 0x58, 0x53, 13, 10, 26, 10]):
		return "not a .vxs file"
	if bytes.decode_u32(8) != 2:
		return "version %d of the format: this add-on reads 2" % bytes.decode_u32(8)
	var sections := {}
	for n in bytes.decode_u32(12):
		var at := 64 + 48 * n
		if at + 48 > bytes.size():
			return DAMAGED
		var begin := bytes.decode_u64(at + 16)
		var size := bytes.decode_u64(at + 24)
		if begin < 0 or size < 0 or begin + size > bytes.size():
			return DAMAGED
		var content := bytes.slice(begin, begin + size)
		if Hash.of(content) != bytes.decode_s64(at + 40): # Godot for the web ends where zstd meets damage
			return DAMAGED
		sections[bytes.slice(at, at + 4).get_string_from_ascii() + str(bytes.decode_s32(at + 8))] = \
				content if bytes.decode_u32(at + 4) & 2 else _inflated(content, bytes.decode_u64(at + 32))
	var table: PackedByteArray = sections.get("LGHT-1", PackedByteArray())
	if table.size() < 8 + RECORD or table.size() != 8 + RECORD * table.decode_u32(0):
		return DAMAGED
	for n in table.decode_u32(0):
		var record := table.slice(8 + RECORD * n, 8 + RECORD * (n + 1))
		names.append(record.slice(192).get_string_from_utf8())
		if record.decode_u32(176) != 2:
			return "light '%s' is a DAG, which this add-on does not read: bake without --coding dag" % names[n]
		if record.decode_u32(180) != 1:
			return "light '%s' is packed small: bake with --pack fast, or use vxs export" % names[n]
		_add_constants(record)
		if not _add_words(sections.get("RSDT%d" % n, PackedByteArray()), sections.get("PAGE%d" % n, PackedByteArray()), record.decode_u32(8)):
			return DAMAGED
	words.resize(words.size() + 16)
	return ""


func _inflated(bytes: PackedByteArray, size: int) -> PackedByteArray:
	if size <= 0 or size > MOST * bytes.size():
		return PackedByteArray()
	return bytes.decompress(size, FileAccess.COMPRESSION_ZSTD)


func _add_constants(record: PackedByteArray) -> void:
	var out := PackedByteArray()
	out.resize(96)
	for k in 12:
		var number := record.decode_double(16 + 8 * k)
		out.encode_float(4 * k, number + 0.0 if k % 4 == 3 else number) # no -0 in the last column, as in C
	for k in 5: # texel, voxel, near, range, cos_outer
		out.encode_float(48 + 4 * k, record.decode_double([112, 120, 152, 168, 160][k]))
	for k in 5: # kind, flags, levels, first word, coding
		out.encode_u32(68 + 4 * k, [record.decode_u32(0), record.decode_u32(12), record.decode_u32(4), words.size() / 4, 2][k])
	constants.append_array(out)


# Append the words of a light. Returns false for bytes that are damaged.
func _add_words(resident: PackedByteArray, pages: PackedByteArray, word_count: int) -> bool:
	if resident.size() < 17 or pages.size() < 8:
		return false
	var count := resident.decode_u32(4)
	var next := resident.decode_u32(0)
	if next > word_count or next < 8 + count or pages.decode_u32(0) != count or pages.size() < 8 + 16 * count:
		return false
	var out := _inflated(resident.slice(16), 4 * next + resident.decode_u32(12))
	if out.size() < 4 * next:
		return false
	out.resize(4 * next)
	var at := 8 + 16 * count
	for n in count:
		var stored := pages.decode_u32(8 + 16 * n)
		var size := pages.decode_u32(12 + 16 * n)
		if stored < 5 or at + stored > pages.size() or size < 1 or size > 65536 or next + size > word_count:
			return false
		var bytes := _inflated(pages.slice(at + 4, at + stored), 4 * size)
		_page = bytes.to_int32_array()
		if _page.size() != size or not _name_new(pages.decode_u16(at + 2) + 1):
			return false
		out.encode_u32(32 + 4 * n, next)
		out.append_array(_page.to_byte_array())
		next += size
		at += stored
	words.append_array(out)
	return next == word_count


# A half, byte of the page; zero behind its end.
func _get_half(at: int) -> int:
	return _page[at >> 1] >> 16 * (at & 1) & 0xffff if at >> 1 < _page.size() else 0


func _get_byte(at: int) -> int:
	return _get_half(at >> 1) >> 8 * (at & 1) & 0xff


func _bits(x: int) -> int:
	var count := 0
	x &= 0xffffffff
	while x:
		x &= x - 1
		count += 1
	return count


# In the words of a page, names of new blocks and patterns are 0: put in where those start, which is behind the last one.
func _name_new(node_words: int) -> bool:
	var at := 0
	_half = 2 * node_words
	while at < node_words:
		if at + 6 > _page.size():
			return false
		var mixed := _bits(_page[at]) + _bits(_page[at + 1])
		var wide := 1 + (_page[at + 5] & 1)
		var name := 2 * at + 11
		at += (11 + mixed + wide * (mixed + _bits(_page[at + 2]) + _bits(_page[at + 3])) + 1) / 2
		for n in range(name, name + mixed):
			if n >> 1 >= _page.size():
				return false
			if _get_half(n):
				continue
			_page[n >> 1] |= at << 16 * (n & 1)
			at = _name_patterns(at)
			if at > node_words or at > 65535:
				return false
	return _half <= 2 * _page.size()


# The block at a word. Returns where it ends.
func _name_patterns(at: int) -> int:
	if at + 2 > _page.size():
		return at + 65536
	var mixed := _page[at] & 0xffff
	var head := _page[at + 1]
	var own := head & 0xffff
	var tile := at + (4 if own & ~mixed else 2)
	var palette := tile + _bits(mixed)
	for t in 16:
		if not mixed >> t & 1:
			continue
		if tile >= _page.size():
			return at + 65536
		if _page[tile] >> 14 & 0x3ffff == 0:
			_page[tile] |= _half << 14
			_half += _private_halves(_half) if own >> t & 1 else _pattern_halves(_half, _bits(_page[tile] & 0x3fff))
		tile += 1
	var bytes := 4 * palette + ((head >> 16 & 15) << (head >> 24 & 3)) + (_bits(_page[at] >> 16 & 0xffff) + 1) / 2
	return (bytes + 3) / 4 + (_bits(own & mixed) if head >> 26 & 1 else 0)


func _pattern_halves(at: int, depths: int) -> int:
	if _get_byte(2 * at) == 0xff:
		return 17
	var size := depths / 2
	for n in depths - 1:
		var states := _get_byte(2 * at + n)
		size += _bits(states >> 1 & ~states & 0x55)
	return size


func _private_halves(at: int) -> int:
	var head := _get_half(at)
	var kind := head >> 12
	if kind > 2:
		return PRIVATE_HALVES[kind] if kind < PRIVATE_HALVES.size() else 1
	var deltas := (head & 0xff) - 1
	var halves: int = [(deltas + 1) / 2, deltas, 2 * deltas][kind]
	return 1 + halves + _pattern_halves(at + 1 + halves, deltas + 1)
