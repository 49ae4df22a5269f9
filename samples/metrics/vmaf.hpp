// SPDX-License-Identifier: Apache-2.0
// VMAF of a picture against a reference, by an FFmpeg with libvmaf that is somebody else's: a child
// process for each pair. Downloads nothing and brings no model. Called by compare and chart.
#pragma once

#include "framework/core/image.hpp"

#include <filesystem>
#include <string>

namespace ockham {

class Vmaf {
public:
    /// `ffmpeg`: a file, or a name in PATH; empty: $OCKHAM_FFMPEG, else "ffmpeg". `model`: the
    /// `.json` of libvmaf 2 and later, or the `.pkl` of libvmaf 1 with its `.pkl.model` beside it;
    /// empty: $OCKHAM_VMAF_MODEL, else libvmaf's own. Measures a small picture; throws Error(input)
    /// naming the program and what it said where that fails.
    explicit Vmaf(const std::string& ffmpeg = {}, const std::filesystem::path& model = {});

    /// Of R, G, B as displayed, both of one size of 16 x 16 pixels or more, as a film of one frame,
    /// whose score for equal pictures is about 97.4 with the model v0.6.1: nothing moves. From 0 to
    /// 100. Only luma counts (BT.709, 8 bits, video range), as the model was made. Throws
    /// Error(input).
    double operator()(const Image& test, const Image& reference) const;

    /// "vmaf_v0.6.1.pkl, libvmaf 1.3.7": the file of the model, and what measured.
    const std::string& made_by() const { return made_by_; }

private:
    struct Measured {
        double score;
        std::string version; ///< of libvmaf
    };
    Measured measure(const Image& test, const Image& reference) const;

    std::string program_;
    std::filesystem::path model_;
    bool names_paths_ = false; ///< libvmaf 2 and later: model=path=F, not model_path=F
    std::string made_by_;
};

} // namespace ockham
