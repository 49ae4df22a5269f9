// SPDX-License-Identifier: Apache-2.0
// viewer: scenes and volumes in a window, with every parameter at hand. README.md beside this file
// has examples.
#include "framework/core/log.hpp"
#include "samples/viewer/viewer.hpp"
#include "samples/viewer/widgets.hpp"

#include <filesystem>
#include <string>
#include <vector>

using namespace ockham;
using namespace ockham::viewer;

namespace {

constexpr const char* kDescription =
    "Shows a scene (.gltf, .glb), a volume (.nrrd, .nii, .vdb, ...) or both in a window: turn by "
    "dragging, move by a right drag and the wheel; files can be dropped onto it. The flags are "
    "those of adaptive_aa, volume_gi or surface_volume, by what is shown; for those of another, "
    "name it: viewer builtin:cloud --help";

/// A bare `viewer` goes on where the last session ended.
std::vector<std::string> words_of(int argc, char** argv) {
    std::vector<std::string> words(argv, argv + argc);
    std::error_code failed;
    if (argc == 1 && std::filesystem::exists(session_path(), failed)) {
        words.insert(words.end(), {"--config", session_path().string()});
        log::info("the last session, '{}'; for another name a scene or a volume", words.back());
    }
    return words;
}

int view(int argc, char** argv) {
    auto subject = std::make_unique<Subject>(kind_of_command(argc, argv));
    if (const std::optional<int> done =
            parse_command_line(argc, argv, kDescription, subject->params, subject->common))
        return *done;

    const CommonOptions& common = subject->common;
    const Gui gui;
    Window window(common.width, common.height, "Ockham viewer");
    gpu::DeviceOptions options = device_options(common);
    options.instance_extensions = window.instance_extensions();
    options.device_extensions = Presenter::device_extensions();
    gpu::Device device(options);
    watch_shaders(device, common);
    log::info("{} ({})", device.info().name, device.info().driver_version);
    {
        Presenter presenter(window, device);
        Viewer viewer(window, device, presenter, std::move(subject));
        viewer.run();
    }
    expect_no_validation_messages(device);
    return interrupted() ? 130 : 0;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] {
        std::vector<std::string> words = words_of(argc, argv);
        std::vector<char*> pointers;
        for (std::string& word : words) pointers.push_back(word.data());
        pointers.push_back(nullptr);
        return view(static_cast<int>(words.size()), pointers.data());
    });
}
