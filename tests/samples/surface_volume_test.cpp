// SPDX-License-Identifier: Apache-2.0
// surface_volume as a user runs it: one picture of both, equal bits for equal flags, statistics,
// and one clear error, without a file, for everything that can be wrong.
#include "framework/core/file.hpp"
#include "framework/io/image_file.hpp"
#include "tests/support/program_test.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ockham {
namespace {

class SurfaceVolumeProgram : public test::ProgramTest {
protected:
    SurfaceVolumeProgram() : ProgramTest("surface_volume") {
        write_text(folder / "ball.raw", std::string(8 * 8 * 8, '\x7f'));
        write_text(folder / "ball.json",
            R"({"file": "ball.raw", "dims": [8, 8, 8], "type": "uint8", "spacing_mm": [1, 1, 1]})");
        write_text(folder / "fog.json", R"({"points": [{"value": 0, "opacity": 1}]})");
    }
    const std::string size = " --width 24 --height 18 --validation core --quiet ";
    const std::string both = "builtin:plane ball.json --transfer fog.json --density-scale 2 "
                             "--place '0,1,-4 0,30,0 2' --steps 3" +
                             size;
};

TEST_F(SurfaceVolumeProgram, renders_both_into_one_picture) {
    const test::Result result = run(both + "-o a.exr --stats a.json --plan a.txt");
    ASSERT_EQ(result.exit_code, 0) << result.text;
    ASSERT_EQ(run(both + "-o b.exr").exit_code, 0);
    const Image a = load_image(folder / "a.exr"), b = load_image(folder / "b.exr");
    for (int c = 0; c < 4; ++c) EXPECT_TRUE(std::ranges::equal(a.plane(c), b.plane(c)));
    const auto stats = nlohmann::json::parse(read_text(folder / "a.json"));
    EXPECT_GT(stats.at("samples").at("percent").get<double>(), 6.0);
    EXPECT_GT(stats.at("volume").at("paths").get<int>(), 0);
    EXPECT_EQ(stats.at("volume").at("truncated"), 0);
    EXPECT_NE(read_text(folder / "a.txt").find("over_meshes"), std::string::npos);
}

TEST_F(SurfaceVolumeProgram, leaves_out_what_is_not_there) {
    ASSERT_EQ(run("builtin:plane" + size + "-o a.exr --plan a.txt").exit_code, 0);
    EXPECT_NE(read_text(folder / "a.txt").find("no volume"), std::string::npos);
    const test::Result result =
        run("ball.json --transfer fog.json --steps 1 --plan b.txt -o b.png" + size);
    ASSERT_EQ(result.exit_code, 0) << result.text;
    EXPECT_EQ(read_text(folder / "b.txt").find("pass 'gbuffer' is kept"), std::string::npos);
}

TEST_F(SurfaceVolumeProgram, says_what_is_wrong_and_writes_nothing) {
    const std::string out = " -o x.exr" + size;
    expect_error("builtin:plane ball.json ball.json" + out, 2, {"2 volumes", "expected one"});
    expect_error("builtin:plane missing.nrrd" + out, 2, {"missing.nrrd"});
    expect_error("missing.gltf ball.json" + out, 2, {"missing.gltf"});
    expect_error("builtin:plane builtin:nothing" + out, 2, {"nothing"});
    for (const char* place : {"1,2,3", "1,2 0,0,0 1", "0,0,0 0,0,0 0", "0,0,0 0,0,0 -1",
             "nan,0,0 0,0,0 1", "0,0,0 0,0,0 1 1"})
        expect_error("builtin:plane ball.json --place '" + std::string(place) + "'" + out, 2,
            {"--place", "tx,ty,tz rx,ry,rz scale"});
    expect_error("ball.json --place '0,0,0 0,0,0 1'" + out, 2, {"--place", "no scene"});
    expect_error("builtin:plane --place '0,0,0 0,0,0 1'" + out, 2, {"--place", "no volume"});
    expect_error("builtin:plane ball.json --steps 0" + out, 2, {"--steps"});
    expect_error(
        "builtin:plane ball.json --transfer fog.json --method fxaa" + out, 2, {"--method"});
    expect_error(
        "builtin:plane ball.json --transfer fog.json --preset paper" + out, 2, {"--resolve"});
    expect_error("builtin:plane ball.json --light '0,0,0 1,1,1'" + out, 2, {"--light"});
    expect_error("builtin:plane ball.json -o nowhere/x.exr" + size, 2, {"nowhere"});
}

} // namespace
} // namespace ockham
