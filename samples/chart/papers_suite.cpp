// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/papers_suite.hpp"

#include "samples/chart/paper_aa.hpp"
#include "samples/chart/paper_volume.hpp"

namespace ockham::chart {
namespace {

class PapersSuite : public Suite {
public:
    explicit PapersSuite(Context& context) : surfaces_(context, list_), volumes_(context, list_) {}
    std::string name() const override { return "papers"; }
    std::vector<Job> jobs() override { return list_.jobs(); }
    /// Its subjects take turns themselves.
    std::size_t together() const override { return 1; }
    std::unique_ptr<Subject> open(const Job& job) override { return list_.open(job); }
    Section report(const Store& store, const std::vector<Point>& points) override {
        Section section{.title = "The papers",
            .text = "M. Holländer, T. Boubekeur, E. Eisemann: <i>Adaptive Supersampling for "
                    "Deferred Anti-Aliasing</i>, JCGT 2(1), 2013; U. Šmajdek, Ž. Lesar, M. Marolt, "
                    "C. Bohak: <i>Combined volume and surface rendering with global illumination "
                    "caching</i>, The Visual Computer, 2023. Scenes, volumes and devices are not "
                    "theirs: what compares is how rows of one column relate, not the two columns."};
        surfaces_.report(store, points, section);
        volumes_.report(store, points, section);
        return section;
    }

private:
    JobList list_;
    PaperAa surfaces_;
    PaperVolume volumes_;
};

} // namespace

std::unique_ptr<Suite> make_papers_suite(Context& context) {
    return std::make_unique<PapersSuite>(context);
}

} // namespace ockham::chart
