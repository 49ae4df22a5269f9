// SPDX-License-Identifier: Apache-2.0
// Executes barriers earlier, together with others: each may run anywhere between the last use that
// it waits for and its own step. Of all such intervals, the fewest points that meet each are found
// by taking them by their ends (Gavril 1972): the latest batch, if it is late enough, else a new
// one.
#include "framework/graph/compile/drafts.hpp"

#include <algorithm>

namespace ockham {

void gather(const Plan& plan, std::vector<Draft>& drafts, const std::vector<Past>& pasts) {
    struct Latest {
        std::uint32_t drafted = kNone, moved = 0;
    };
    std::vector<Latest> latest(plan.resources.size()); // barrier of each resource
    const auto exit = static_cast<std::uint32_t>(plan.steps.size());
    auto submission = plan.submissions.begin();
    std::uint32_t batch = 0; // the latest
    for (std::size_t i = 0; i < drafts.size(); ++i) {
        Draft& draft = drafts[i];
        if (draft.dead || draft.release || draft.step == exit) continue;
        while (submission->first_step + submission->step_count <= draft.step) ++submission;
        // What another queue did is waited for at the beginning of the submission.
        std::uint32_t earliest = submission->first_step;
        for (std::uint32_t p = draft.first_past; p < draft.first_past + draft.past_count; ++p) {
            const Past& past = pasts[p];
            if (past.queue == submission->queue && past.when > 0)
                earliest = std::max(earliest, static_cast<std::uint32_t>(past.when));
        }
        // Barriers of one resource may rely on each other.
        Latest& before = latest[plan.barriers[i].resource];
        if (before.drafted != kNone)
            earliest = std::max(earliest, before.moved + (before.drafted != draft.step));
        before.drafted = draft.step;
        if (batch < earliest || batch > draft.step) batch = draft.step;
        before.moved = draft.step = batch;
    }
}

} // namespace ockham
