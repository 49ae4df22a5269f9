// SPDX-License-Identifier: Apache-2.0
// What charts have measured, on disk: one line of JSON for each finished repeat, only ever added
// to, so that an interrupted run continues and nothing is measured twice. Not for pictures, which
// lie beside it as files. Called by the runner of suite.hpp and by what draws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace ockham::chart {

/// One thing to measure: a series at one setting, on one scene. A job that yields a whole curve at
/// once, as error over time does, has one row for each point of it.
struct Job {
    std::string suite;     ///< "aa"
    std::string scene;     ///< as for people: "fence"
    std::string series;    ///< what one curve consists of: "ockham"
    std::string setting{}; ///< what tells jobs of a series apart: "lambda 1e-05"; may be empty
    /// All else that the numbers depend on: size, flags, fingerprints of files, device and driver.
    std::string inputs{};
    std::string command{}; ///< a command line that shows the same by hand
    int repeats = 0;       ///< 0: as --repeats says; 1 for what is the same each time

    /// 16 hexadecimal digits of everything above but command and repeats, and of the commit.
    std::string key() const;
};

/// Numbers by name: "total_gpu_ms", "psnr". Not finite: left out, but an infinite PSNR is 999.
using Values = std::map<std::string, double>;

/// What was measured at one position of the knob, or at one moment of a run.
struct Row {
    double knob = 0;
    Values values;
};

/// One finished repeat of a job.
struct Repeat {
    std::vector<Row> rows;
    std::map<std::string, std::string> pictures{}; ///< name to file, relative to the store's folder
};

/// Middle and reach of what repeats gave: the quartiles from four values on, else least and most.
struct Spread {
    double low = 0, median = 0, high = 0;
};
Spread spread(std::vector<double> values); ///< at least one value

/// A row of a job over its repeats.
struct Point {
    const Job* job = nullptr;
    double knob = 0;
    std::map<std::string, std::vector<double>> values; ///< one for each repeat that has it

    bool has(const std::string& name) const { return values.contains(name); }
    Spread operator[](const std::string& name) const { return spread(values.at(name)); }
};

class Store {
public:
    /// Opens `folder`/measured.jsonl, or begins it; makes the folder. A last line that a killed run
    /// left unfinished is cut off. Throws Error(input) naming file and line where another is no
    /// measurement, where the file cannot be written, and where another process has it open.
    explicit Store(std::filesystem::path folder);
    ~Store();
    Store(const Store&) = delete;
    Store& operator=(const Store&) = delete;

    const std::filesystem::path& folder() const { return folder_; }
    /// Finished repeats of a job, whoever measured them.
    const std::vector<Repeat>& repeats(const Job& job) const;
    /// On the disk when this returns.
    void add(const Job& job, const Repeat& repeat);

private:
    void load(const std::filesystem::path& path);

    std::filesystem::path folder_;
    int file_ = -1;
    std::map<std::string, std::vector<Repeat>> repeats_; ///< by key
};

/// Rows of finished jobs, in the order of `jobs`, then of rows. Rows of several repeats of a job
/// are brought together by their place.
std::vector<Point> points_of(const Store& store, const std::vector<Job>& jobs);

/// 16 hexadecimal digits (FNV-1a) of a text.
std::string fingerprint(std::string_view text);
/// Of a file's content; of a folder, and of the folder around a `.gltf`, whose buffers and textures
/// lie beside it: of all names, sizes and times of change. A `builtin:` name stands for itself.
std::string fingerprint_of(const std::string& scene);

} // namespace ockham::chart
