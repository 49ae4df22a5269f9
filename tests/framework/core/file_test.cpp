// SPDX-License-Identifier: Apache-2.0
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

namespace ockham {
namespace {

namespace fs = std::filesystem;

class FileTest : public testing::Test {
protected:
    FileTest()
        : folder(fs::temp_directory_path() / ("ockham_file_test." + std::to_string(::getpid()))) {
        fs::create_directories(folder);
    }
    ~FileTest() override { fs::remove_all(folder); }

    std::size_t entries() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
    }

    fs::path folder;
};

template <class F>
std::string error_of(F f) {
    try {
        f();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "";
}

TEST_F(FileTest, reads_back_what_it_wrote) {
    std::string text = "a\0b\n";
    text.resize(100000, 'x');
    write_text(folder / "f", text);
    EXPECT_EQ(read_text(folder / "f"), text);
    write_text(folder / "f", "");
    EXPECT_EQ(read_text(folder / "f"), "");
    EXPECT_EQ(entries(), 1u) << "no temporary is left";
}

TEST_F(FileTest, names_the_path_and_the_reason) {
    EXPECT_EQ(error_of([&] { read_text(folder / "none"); }),
        "cannot open '" + (folder / "none").string() + "': No such file or directory");
    EXPECT_NE(error_of([&] { read_text(folder); }).find("it is a folder"), std::string::npos);
    write_text(folder / "big", "12345");
    EXPECT_NE(
        error_of([&] { read_text(folder / "big", 4); }).find("it has 5 bytes, the limit is 4"),
        std::string::npos);
    EXPECT_NE(error_of([&] { write_text(folder / "no" / "f", "x"); }).find("No such file"),
        std::string::npos);
    EXPECT_NE(error_of([&] { write_text(folder, "x"); }).find("it is a folder"), std::string::npos);
    EXPECT_NE(
        error_of([] { read_text("/dev/zero"); }).find("not a regular file"), std::string::npos);
}

TEST_F(FileTest, full_device_is_an_error) {
    EXPECT_NE(
        error_of([] { write_text("/dev/full", "x"); }).find("No space left"), std::string::npos);
}

TEST_F(FileTest, failed_write_leaves_the_old_file_and_no_temporary) {
    write_text(folder / "f", "old");
    EXPECT_EQ(error_of([&] {
        write_atomically(folder / "f", [](const fs::path& temporary) {
            std::ofstream(temporary) << "half";
            fail_input("gave up");
        });
    }),
        "gave up");
    EXPECT_EQ(read_text(folder / "f"), "old");
    EXPECT_EQ(entries(), 1u);
}

TEST_F(FileTest, file_size_limit_leaves_nothing) {
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit small = before;
    small.rlim_cur = 1000;
    ::setrlimit(RLIMIT_FSIZE, &small);
    const std::string error = error_of([&] { write_text(folder / "f", std::string(5000, 'x')); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_NE(error.find("File too large"), std::string::npos) << error;
    EXPECT_EQ(entries(), 0u);
}

TEST_F(FileTest, check_writable_tells_and_leaves_nothing) {
    check_writable(folder / "f");
    EXPECT_EQ(entries(), 0u);
    EXPECT_NE(error_of([&] { check_writable(folder / "no" / "f"); }), "");
    EXPECT_NE(error_of([&] { check_writable(folder); }), "");
}

} // namespace
} // namespace ockham
