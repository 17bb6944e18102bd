// The limits of the wire that this page keeps to. The server's are in server/net/guard/limits.h and server/net/protocol.h; a test
// sees that they agree.

export const HEADER_BYTES = 64; // of a frame
export const SMALLEST_SIDE = 16; // of a picture, pixels
export const LARGEST_SIDE = 8192;
export const LARGEST_PIXELS = 33_177_600;
export const LONGEST_PRESENTED_MS = 3_600_000; // of an acknowledgement
