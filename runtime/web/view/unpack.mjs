// Files that the bundle holds as base64 of gzip.
// SPDX-License-Identifier: MIT

/** The bytes of a packed file. */
export async function unpack(packed) {
  const stream = new Blob([Uint8Array.from(atob(packed), (c) => c.charCodeAt(0))]).stream();
  return new Uint8Array(
    await new Response(stream.pipeThrough(new DecompressionStream('gzip'))).arrayBuffer(),
  );
}
