// SPDX-License-Identifier: Apache-2.0
#include "framework/io/dicom_check.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ockham {
namespace {

constexpr std::size_t kPreamble = 128;
constexpr std::string_view kMark = "DICM";
constexpr std::uint32_t kUndefined = 0xFFFFFFFF;
constexpr std::size_t kMaxDepth = 64;

// Tags: group << 16 | element.
constexpr std::uint32_t kTransferSyntax = 0x0002'0010, kSamples = 0x0028'0002,
                        kFrames = 0x0028'0008, kRows = 0x0028'0010, kColumns = 0x0028'0011,
                        kBitsAllocated = 0x0028'0100, kPixels = 0x7FE0'0010, kItem = 0xFFFE'E000,
                        kSequenceEnd = 0xFFFE'E0DD;

struct Element {
    std::uint32_t tag = 0;
    std::string_view type; ///< of the value; empty where the encoding leaves it out
    std::uint32_t length = 0;
};

class Walk {
public:
    Walk(std::span<const std::byte> bytes, const std::string& file) : bytes_(bytes), file_(file) {}

    void run() {
        at_ = kPreamble + kMark.size();
        while (true) {
            // The head of the file is always written explicitly, little endian.
            const bool in_head = at_ + 2 <= bytes_.size() && number(at_, 2, false) == 2;
            if (!in_head && !in_body_) enter_body();
            const std::size_t start = at_;
            if (start == bytes_.size()) {
                fail_input("cannot load volume '{}': it has no pixels, or is cut off after {} "
                           "bytes",
                    file_, start);
            }
            const Element element = next(in_head);
            if (element.tag == kPixels && open_.empty()) return check_pixels(start, element);
            if (element.length == kUndefined) {
                descend(element);
                continue;
            }
            need(start, element.length);
            remember(element);
            at_ += element.length;
        }
    }

private:
    [[noreturn]] void fail(std::size_t start, const std::string& what) const {
        fail_input("cannot load volume '{}': its DICOM element at byte {} {}; it has {} bytes and "
                   "is damaged or cut off",
            file_, start, what, bytes_.size());
    }
    void need(std::size_t start, std::uint64_t count) const {
        if (count > bytes_.size() - std::min(at_, bytes_.size()))
            fail(start, "lies beyond its end");
    }
    std::uint32_t number(std::size_t at, std::size_t count, bool big) const {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t from = big ? i : count - 1 - i;
            value = value << 8 | static_cast<std::uint32_t>(bytes_[at + from]);
        }
        return value;
    }
    std::string_view text(std::size_t at, std::size_t count) const {
        return {reinterpret_cast<const char*>(bytes_.data() + at), count};
    }

    /// Its tag, type and length (PS3.5, 7.1); moves on to its value.
    Element next(bool in_head) {
        const std::size_t start = at_;
        need(start, 8);
        const bool big = big_ && !in_head;
        Element element{number(at_, 2, big) << 16 | number(at_ + 2, 2, big), {}, 0};
        const bool is_item = element.tag >> 16 == 0xFFFE;
        const bool implicit = open_.empty() ? implicit_ && !in_head : open_.back();
        if (is_item || implicit) {
            element.length = number(at_ + 4, 4, big);
            at_ += 8;
            return element;
        }
        element.type = text(at_ + 4, 2);
        constexpr std::string_view kLong[] = {
            "OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"};
        if (std::ranges::find(kLong, element.type) == std::end(kLong)) {
            element.length = number(at_ + 6, 2, big);
            at_ += 8;
            return element;
        }
        need(start, 12);
        element.length = number(at_ + 8, 4, big);
        at_ += 12;
        return element;
    }

    /// Into a sequence or item whose end is marked; sequences of unknown type are implicit.
    void descend(const Element& element) {
        if (element.tag == kItem) return;
        if (open_.size() >= kMaxDepth) fail(at_, "is nested too deeply");
        open_.push_back(element.type == "UN" || (open_.empty() ? implicit_ : open_.back()));
    }

    void enter_body() {
        in_body_ = true;
        implicit_ = syntax_ == "1.2.840.10008.1.2";
        big_ = syntax_ == "1.2.840.10008.1.2.2";
        if (syntax_ == "1.2.840.10008.1.2.1.99") {
            fail_input("cannot load volume '{}': deflated DICOM files are not read; save it "
                       "without that",
                file_);
        }
    }

    void remember(const Element& element) {
        if (element.tag == kSequenceEnd && !open_.empty()) open_.pop_back();
        if (!open_.empty()) return;
        const auto value = [&] {
            return element.length >= 2 ? number(at_, 2, big_) : std::uint32_t{0};
        };
        if (element.tag == kTransferSyntax) {
            syntax_ = text(at_, element.length);
            syntax_ = syntax_.substr(0, syntax_.find_last_not_of(std::string_view("\0 ", 2)) + 1);
        }
        if (element.tag == kSamples) samples_ = value();
        if (element.tag == kRows) rows_ = value();
        if (element.tag == kColumns) columns_ = value();
        if (element.tag == kBitsAllocated) bits_ = value();
        if (element.tag == kFrames) {
            const std::string count(text(at_, element.length));
            frames_ = std::strtoul(count.c_str(), nullptr, 10);
        }
    }

    void check_pixels(std::size_t start, const Element& element) {
        if (element.length != kUndefined) {
            need(start, element.length);
            const std::uint64_t pixels = std::uint64_t{rows_} * columns_ * samples_;
            const std::uint64_t most = std::uint64_t{1} << 40;
            if (pixels == 0 || frames_ == 0 || frames_ > most / pixels || bits_ > 64) {
                fail(start,
                    fmt::format("has {} frames of {} x {} pixels", frames_, columns_, rows_));
            }
            const std::uint64_t needed = pixels * frames_ * bits_ / 8;
            if (element.length < needed) {
                fail(start,
                    fmt::format("has {} of the {} bytes of its pixels", element.length, needed));
            }
            return;
        }
        // Packed pixels: items until the end of their sequence (PS3.5, A.4).
        std::uint64_t packed = 0;
        while (true) {
            const std::size_t item = at_;
            need(item, 8);
            const Element piece{number(at_, 2, false) << 16 | number(at_ + 2, 2, false), {},
                number(at_ + 4, 4, false)};
            at_ += 8;
            if (piece.tag == kSequenceEnd) return check_packed(start, packed);
            if (piece.tag != kItem) fail(item, "is none of the pieces of its pixels");
            need(item, piece.length);
            at_ += piece.length;
            packed += piece.length;
        }
    }

    /// Before room is made for what so few bytes cannot hold, by a generous guess.
    void check_packed(std::size_t start, std::uint64_t packed) const {
        constexpr std::uint64_t kMaxRatio = 1 << 16;
        const std::uint64_t pixels = std::uint64_t{rows_} * columns_;
        if (frames_ <= kMaxRatio * (packed + 1) / std::max<std::uint64_t>(pixels, 1)) return;
        fail(start, fmt::format("has {} bytes for {} frames of {} x {} pixels", packed, frames_,
                        columns_, rows_));
    }

    std::span<const std::byte> bytes_;
    const std::string& file_;
    std::size_t at_ = 0;
    std::string_view syntax_;
    bool in_body_ = false, implicit_ = false, big_ = false;
    std::vector<bool> open_; ///< sequences without a length: whether each is implicit
    std::uint32_t rows_ = 0, columns_ = 0, samples_ = 1, bits_ = 0;
    std::uint64_t frames_ = 1;
};

} // namespace

bool is_dicom(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::string mark(kMark.size(), ' ');
    stream.seekg(kPreamble);
    return stream.read(mark.data(), static_cast<std::streamsize>(mark.size())) && mark == kMark;
}

void check_dicom(const std::filesystem::path& path) {
    const std::string file = path.string();
    const std::vector<std::byte> bytes = read_file(path);
    Walk(bytes, file).run();
}

} // namespace ockham
