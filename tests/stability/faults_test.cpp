// SPDX-License-Identifier: Apache-2.0
// The first call of every entry point fails, in every way it can, and the program ends as it
// should.
#include "tests/stability/fault_walk.hpp"

namespace ockham::test {
namespace {

class Faults : public FaultWalk, public testing::WithParamInterface<FaultJob> {};

TEST_P(Faults, of_first_calls_end_in_one_line) {
    EXPECT_GT(walk(GetParam(), [](unsigned n, unsigned) { return n == 1; }), 40u);
}

INSTANTIATE_TEST_SUITE_P(
    , Faults, testing::ValuesIn(kFaultJobs), [](const auto& job) { return job.param.program; });

} // namespace
} // namespace ockham::test
