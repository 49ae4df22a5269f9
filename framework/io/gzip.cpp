// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gzip.hpp"

#include "framework/core/error.hpp"

#include <zlib.h>

#include <algorithm>
#include <limits>

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

} // namespace

std::uint64_t inflate(std::span<const std::byte> packed, std::span<std::byte> bytes) {
    Stream stream;
    Bytef beyond = 0; // where a byte too many goes
    std::size_t in = 0, out = 0;
    while (true) {
        const uInt available_in = chunk(packed.size() - in);
        const uInt available_out = out < bytes.size() ? chunk(bytes.size() - out) : 1;
        // The library only reads here, although its type allows it to write.
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data() + in));
        stream.avail_in = available_in;
        stream.next_out =
            out < bytes.size() ? reinterpret_cast<Bytef*>(bytes.data() + out) : &beyond;
        stream.avail_out = available_out;
        const int result = ::inflate(&stream, Z_NO_FLUSH);
        in += available_in - stream.avail_in;
        out += available_out - stream.avail_out;
        if (out > bytes.size()) return out;
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

} // namespace ockham
