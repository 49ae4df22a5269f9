// SPDX-License-Identifier: Apache-2.0
// What a run of the viewer is about: which technique, all parameters with their declarations, and
// the technique itself once there is a device. Tells scenes from volumes. Called by the viewer.
#pragma once

#include "samples/viewer/surface_volume_technique.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ockham::viewer {

enum class Kind { surface, volume, both };

/// By name: glTF and built-in scenes are surfaces, all else is left to the readers of volumes.
/// None: a scene.
Kind kind_of(const std::vector<std::string>& sources);

struct Subject {
    explicit Subject(Kind kind);
    Subject(const Subject&) = delete;
    Subject& operator=(const Subject&) = delete;

    /// The technique, from the parameters as they are. Throws Error(input), and what was there is
    /// gone then.
    void open(gpu::Device& device);
    void set_sources(const std::vector<std::string>& sources);

    Kind kind;
    CommonOptions common;
    SurfaceVolumeOptions options; ///< what the kind does not need has its defaults
    int frames = 0, orbit = 0;
    std::string screenshot;
    std::optional<TransferFunction> drawn; ///< in place of --transfer
    Params params;                         ///< points to the above
    std::unique_ptr<Technique> technique;
};

/// Words of the command line that are no flag and no flag's value.
std::vector<std::string> positionals(int argc, char** argv);
/// What to show, by the command line alone, or else by the run file that --config names.
Kind kind_of_command(int argc, char** argv);

/// The parameters of `subject` as a run file of Technique::program(), with `camera` and the
/// picture's size in place of the window's. A transfer function that was drawn goes to a file
/// beside it, NAME_transfer.json.
void save_run_file(const std::filesystem::path& path, Subject& subject, const std::string& camera,
    glm::ivec2 size);

/// In the form of load_transfer(). Throws Error(input) naming the file.
void save_transfer(const std::filesystem::path& path, const TransferFunction& transfer);

/// Where the last session is kept: $XDG_CONFIG_HOME/ockham/viewer.json or under ~/.config; empty
/// where neither is set.
std::filesystem::path session_path();

} // namespace ockham::viewer
