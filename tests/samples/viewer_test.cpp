// SPDX-License-Identifier: Apache-2.0
// The viewer in a real window of a virtual X server, on whatever driver there is: pictures equal
// those of the programs that render without a window, and a person's mouse does not upset it.
#include "framework/core/file.hpp"
#include "framework/io/image_file.hpp"
#include "tests/support/program_test.hpp"
#include "tests/support/virtual_screen.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ockham {
namespace {

using test::Result;

class ViewerProgram : public test::ProgramTest {
protected:
    ViewerProgram() : ProgramTest("viewer") {}
    void SetUp() override { ASSERT_FALSE(screen.name.empty()) << "Xvfb does not start"; }
    std::string surroundings() const {
        return "env -u WAYLAND_DISPLAY DISPLAY=" + screen.name + " XDG_CONFIG_HOME='" +
               folder.string() + "/config'";
    }
    Result view(const std::string& arguments) {
        return run(arguments + " --validation sync", surroundings());
    }
    /// The picture of the other program, with the flags that the viewer's session left, equals.
    void expect_same_picture(const std::string& program, const std::string& flags) {
        const Image shown = load_image(folder / "shown.exr");
        const Result result =
            run(flags + " --width " + std::to_string(shown.width()) + " --height " +
                    std::to_string(shown.height()) + " -o wanted.exr",
                "", program);
        ASSERT_EQ(result.exit_code, 0) << result.text;
        const Image wanted = load_image(folder / "wanted.exr");
        for (const char* channel : {"R", "G", "B"})
            EXPECT_TRUE(std::ranges::equal(shown.plane(channel), wanted.plane(channel))) << channel;
    }
    test::VirtualScreen screen;
};

TEST_F(ViewerProgram, ShowsAScene) {
    const std::string flags = "builtin:wires --m 2";
    const Result result =
        view(flags + " --width 640 --height 360 --frames 1 -o shown.exr --screenshot window.png");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    expect_same_picture("adaptive_aa", flags);

    // The window has the picture at its upper left, as it would be written, and widgets beside it.
    const Image window = load_image(folder / "window.png"),
                picture = load_image(folder / "shown.exr");
    EXPECT_EQ(window.width(), 640);
    EXPECT_EQ(window.height(), 360);
    for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < picture.height(); ++y)
            for (int x = 0; x < picture.width(); ++x)
                ASSERT_NEAR(srgb_encode(window.at(x, y, c)),
                    srgb_encode(std::clamp(picture.at(x, y, c), 0.0f, 1.0f)), 1.01f / 255)
                    << x << " " << y;
    }
    float darkest = 1, brightest = 0;
    for (int y = 0; y < window.height(); ++y)
        for (int x = picture.width() + 4; x < window.width(); ++x) {
            darkest = std::min(darkest, window.at(x, y, 0));
            brightest = std::max(brightest, window.at(x, y, 0));
        }
    EXPECT_LT(darkest, 0.02f);
    EXPECT_GT(brightest, 0.4f); // text
    EXPECT_FALSE(files().contains("config")) << "a run that nobody sat at is no session";
}

TEST_F(ViewerProgram, TurnsAsAHandDoesAndSaysHowFast) {
    const Result result = view("builtin:wires --m 2 --width 640 --height 360 --orbit 9");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_NE(result.text.find("frames while something moved"), std::string::npos) << result.text;
    EXPECT_NE(result.text.find(" a second"), std::string::npos) << result.text;
    EXPECT_FALSE(files().contains("config")) << "a run that nobody sat at is no session";
}

TEST_F(ViewerProgram, ShowsAVolume) {
    const std::string flags = "builtin:cloud --mode path --max-bounces 1";
    const Result result = view(flags + " --width 480 --height 300 --frames 2 -o shown.exr");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    expect_same_picture("volume_gi", flags + " --steps 2");
}

TEST_F(ViewerProgram, ShowsASceneWithAVolumeInIt) {
    write_text(folder / "ball.raw", std::string(8 * 8 * 8, '\x7f'));
    write_text(folder / "ball.json",
        R"({"file": "ball.raw", "dims": [8, 8, 8], "type": "uint8", "spacing_mm": [1, 1, 1]})");
    write_text(folder / "fog.json", R"({"points": [{"value": 0, "opacity": 1}]})");
    const std::string flags =
        "builtin:plane ball.json --transfer fog.json --density-scale 2 --mode path --m 2 "
        "--place '0,1,-4 0,30,0 2' --camera '0,1.5,0.5 0,1,-4 50'";
    const Result result = view(flags + " --width 480 --height 240 --frames 3 -o shown.exr");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    expect_same_picture("surface_volume", flags + " --steps 3");
}

TEST_F(ViewerProgram, SurvivesAPersonAndKeepsTheSession) {
    // Drags, the wheel, keys, a resized and a hidden window; then SIGINT.
    const Result result =
        run("builtin:plane --m 2 --width 600 --height 400 --validation sync > log & "
            "V=$!; export DISPLAY=" +
                screen.name +
                "; W=$(timeout 60 xdotool search --sync --onlyvisible --name 'Ockham viewer')"
                "; P=$(xdotool getwindowpid $W); sleep 1"
                "; xdotool mousemove --window $W 60 60 mousedown 1"
                "; for i in 1 2 3 4 5 6"
                "; do xdotool mousemove_relative 9 3; sleep 0.1; done"
                "; xdotool mouseup 1 click 4 click 5"
                "; xdotool windowsize $W 500 320; sleep 0.5"
                "; xdotool windowunmap $W; sleep 0.3; xdotool windowmap $W"
                "; sleep 0.3; xdotool key --window $W h; sleep 0.3"
                "; xdotool windowsize $W 700 420; sleep 1; kill -INT $P; wait $V",
            "timeout -s INT 120 " + surroundings());
    ASSERT_EQ(result.exit_code, 130) << result.text << read_text(folder / "log");
    const std::string session = "config/ockham/viewer.json";
    ASSERT_TRUE(std::filesystem::exists(folder / session)) << result.text;
    const nlohmann::json kept = nlohmann::json::parse(read_text(folder / session));
    EXPECT_EQ(kept["m"], 2);
    EXPECT_EQ(kept["camera"].get<std::string>().find("nan"), std::string::npos);
    EXPECT_EQ(kept["scene"][0], "builtin:plane");

    // It is a run file of both programs.
    for (const char* program : {"adaptive_aa", "viewer"}) {
        const Result again = run("--config " + session + " --width 500 --height 300 " +
                                     (std::string(program) == "viewer" ? "--frames 1 " : "") +
                                     "-o " + program + ".exr",
            surroundings(), program);
        EXPECT_EQ(again.exit_code, 0) << again.text;
        EXPECT_TRUE(files().contains(std::string(program) + ".exr"));
    }
}

TEST_F(ViewerProgram, SaysWhatIsWrong) {
    expect_error("builtin:wires --frames 1", 3, {"cannot open a window"},
        "env -u WAYLAND_DISPLAY DISPLAY=:nowhere");
    expect_error("builtin:wires --frames 1 --orbit 1", 2, {"--frames", "--orbit"}, surroundings());
    expect_error("nothing.gltf --frames 1", 2, {"nothing.gltf"}, surroundings());
    expect_error("builtin:wires --m 9 --frames 1", 2, {"--m", "1 to 8"}, surroundings());
    expect_error(
        "builtin:wires --method adaptive --budget 1 --frames 1", 2, {"budget"}, surroundings());
}

} // namespace
} // namespace ockham
