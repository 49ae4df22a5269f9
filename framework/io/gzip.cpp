// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gzip.hpp"

#include "framework/core/error.hpp"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace ockham {
namespace {

/// Both headers are recognised (zlib's manual, inflateInit2).
constexpr int kGzipOrZlib = 15 + 32;

struct Stream : z_stream {
    Stream() : z_stream{} {
        if (inflateInit2(this, kGzipOrZlib) != Z_OK) fail_input("out of memory");
    }
    ~Stream() { inflateEnd(this); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
};

/// The library counts in 32 bits.
uInt chunk(std::size_t size) {
    return static_cast<uInt>(std::min<std::size_t>(size, std::numeric_limits<uInt>::max()));
}

/// `room(out)` is where the bytes from `out` go; nothing, if there must be none.
template <class Room>
std::uint64_t run(std::span<const std::byte> packed, Room room) {
    Stream stream;
    std::byte beyond{}; // where a byte too many goes
    std::size_t in = 0;
    std::uint64_t out = 0;
    while (true) {
        std::span<std::byte> into = room(out);
        const bool full = into.empty();
        if (full) into = {&beyond, 1};
        const uInt available_in = chunk(packed.size() - in), available_out = chunk(into.size());
        // The library only reads here, although its type allows it to write.
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data() + in));
        stream.avail_in = available_in;
        stream.next_out = reinterpret_cast<Bytef*>(into.data());
        stream.avail_out = available_out;
        const int result = ::inflate(&stream, Z_NO_FLUSH);
        in += available_in - stream.avail_in;
        out += available_out - stream.avail_out;
        if (full && stream.avail_out == 0) return out;
        if (result == Z_STREAM_END) {
            if (in == packed.size()) return out;
            if (inflateReset(&stream) != Z_OK) fail_input("its gzip data is damaged");
        } else if (result == Z_BUF_ERROR ||
                   (result == Z_OK && in == packed.size() && stream.avail_out != 0)) {
            fail_input("its gzip data ends too early, after {} bytes unpacked", out);
        } else if (result != Z_OK) {
            fail_input("its gzip data is damaged ({}) after {} bytes unpacked",
                stream.msg ? stream.msg : "no reason given", out);
        }
    }
}

} // namespace

std::uint64_t inflate(std::span<const std::byte> packed, std::span<std::byte> bytes) {
    return run(packed, [&](std::uint64_t out) { return bytes.subspan(out); });
}

std::uint64_t inflated_size(std::span<const std::byte> packed, std::uint64_t at_most) {
    std::vector<std::byte> scratch(std::size_t{1} << 16);
    return run(packed, [&](std::uint64_t out) {
        return std::span(scratch).first(std::min<std::uint64_t>(scratch.size(), at_most - out));
    });
}

} // namespace ockham
