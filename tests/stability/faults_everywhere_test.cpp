// SPDX-License-Identifier: Apache-2.0
// Every call of every entry point fails, in every way it can, and the program ends as it should.
#include "tests/stability/fault_walk.hpp"

namespace ockham::test {
namespace {

class FaultsEverywhere : public FaultWalk, public testing::WithParamInterface<FaultJob> {};

TEST_P(FaultsEverywhere, end_in_one_line) {
    const unsigned faults = walk(GetParam(), [](unsigned, unsigned) { return true; });
    RecordProperty("faults", static_cast<int>(faults));
}

INSTANTIATE_TEST_SUITE_P(, FaultsEverywhere, testing::ValuesIn(kFaultJobs),
    [](const auto& job) { return job.param.program; });

} // namespace
} // namespace ockham::test
