// SPDX-License-Identifier: Apache-2.0
#include "framework/runtime/executor.hpp"

#include "framework/gpu/transfer.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/verify.hpp"
#include "framework/runtime/frame.hpp"
#include "framework/runtime/misuse.hpp"
#include "framework/runtime/recorder.hpp"
#include "framework/runtime/resources.hpp"
#include "framework/runtime/submitter.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace ockham {

namespace {

#ifdef NDEBUG
constexpr bool kDebug = false;
#else
constexpr bool kDebug = true;
#endif

ExecutorOptions with_environment(ExecutorOptions options) {
    const char* poison = std::getenv("OCKHAM_POISON");
    options.poison |= poison && std::string_view(poison) == "1";
    return options;
}

Capabilities capabilities_for(const gpu::Device& device, const ExecutorOptions& options) {
    Capabilities capabilities = capabilities_of(device);
    if (!options.pretended_families.empty()) capabilities.families = options.pretended_families;
    return capabilities;
}

/// Texels, channels interleaved, as planes.
Image to_image(
    const VkExtent3D& extent, const gpu::FormatInfo& format, const std::vector<float>& values) {
    const std::vector<std::string> names{"R", "G", "B", "A"};
    Image image(static_cast<int>(extent.width), static_cast<int>(extent.height),
        {names.begin(), names.begin() + format.channels});
    for (std::uint32_t channel = 0; channel < format.channels; ++channel) {
        const std::span<float> plane = image.plane(static_cast<int>(channel));
        for (std::size_t i = 0; i < plane.size(); ++i) {
            plane[i] = values[i * format.channels + channel];
        }
    }
    return image;
}

} // namespace

class Executor::Impl {
public:
    Impl(gpu::Device& device, Graph graph, Plan plan, const Policy& policy,
        const ExecutorOptions& options)
        : device_(device), policy_(policy), options_(with_environment(options)),
          graph_(std::move(graph)), plan_(std::move(plan)),
          answers_(declaration().conditions.size(), 1),
          resources_(device, graph_, plan_, pretends()),
          recorder_(device, graph_, plan_, resources_, {options_.poison, pretends()}),
          submitter_(device, declaration(), plan_, pretends()) {
        check(options.slots > 0, "an executor needs at least one slot");
        if (kDebug || device.validation() == gpu::Validation::sync) expect_verified();
        if (options_.poison) resources_.enable_poison();
        const std::vector<QueueFamily> planned_for = capabilities_for(device, options).families;
        std::vector<std::uint32_t> families;
        for (std::uint32_t i = 0; i < plan_.queues.size(); ++i) {
            families.push_back(submitter_.queue(i).family);
            check(plan_.queues[i].family < planned_for.size(),
                "a plan for other queue families than those pretended");
            families_.push_back(planned_for[plan_.queues[i].family]);
        }
        const auto timestamps =
            static_cast<std::uint32_t>(plan_.steps.size() + plan_.submissions.size());
        for (std::uint32_t i = 0; i < options.slots; ++i) {
            frames_.push_back(std::make_unique<Frame>(
                device, families, options.times && !plan_.steps.empty() ? timestamps : 0));
        }
    }

    ~Impl() {
        try {
            wait_all();
        } catch (const Error&) {
            // The device is lost; whoever executed has been told.
        }
    }

    template <class HandleType, class Real>
    void bind(HandleType handle, const Real& real, const ImportSync& sync) {
        if constexpr (std::is_same_v<Real, gpu::Image>) {
            // Executions before may use them until the latest of these is over, and with it all.
            Frame& latest = *frames_[(next_ + frames_.size() - 1) % frames_.size()];
            for (const VkFramebuffer target : recorder_.forget_targets(handle.resource))
                latest.retired.push_back(target);
        }
        resources_.bind(handle.resource, real);
        std::erase_if(
            points_, [&](const ImportPoint& point) { return point.resource == handle.resource; });
        if (sync.wait.semaphore || sync.signal.semaphore) {
            points_.push_back({handle.resource, sync.wait, sync.signal});
        }
    }

    void set(Condition condition, bool value) {
        check(condition.id < answers_.size(), "set() of a condition that is not of this graph");
        answers_[condition.id] = value;
    }

    void submit() {
        expect_whole();
        resources_.expect_bound();
        if (plan_.submissions.empty() && points_.empty()) return;
        Frame& frame = next_frame();
        begin_execution();
        try {
            // The validation layer misses write-after-write inside one command buffer, and
            // write-after-read between two. So it sees both: the whole frame in one buffer that is
            // never submitted, then one buffer per pass.
            const bool validate = device_.validation() == gpu::Validation::sync;
            if (validate && plan_.submissions.size() == 1)
                record_submission(frame, 0, false, false);
            std::vector<std::vector<VkCommandBuffer>> commands;
            for (const auto& of_queue : frame.commands) (void)of_queue->finish();
            for (std::uint32_t i = 0; i < plan_.submissions.size(); ++i) {
                record_submission(frame, i, frame.timestamps.has_value(), validate);
                commands.push_back(frame.commands[plan_.submissions[i].queue]->finish());
            }
            submitter_.submit(frame, commands, points_);
        } catch (...) {
            broken_ = frame.in_flight;
            abandon_execution();
            throw;
        }
        last_ = &frame;
        finish_execution();
    }

    void record(VkCommandBuffer commands) {
        expect_whole();
        resources_.expect_bound();
        if (plan_.submissions.size() > 1) {
            fail_graph(declaration(), "several-queues",
                "record() needs a plan of one queue, this one has {} submissions to {} queues; "
                "plan it with Policy::async_queues = false, or call submit()",
                plan_.submissions.size(), plan_.queues.size());
        }
        if (!points_.empty()) {
            fail_graph(declaration(), "semaphore-in-record",
                "{} is bound with semaphores, which a command buffer cannot wait for; give them to "
                "the submission instead",
                describe(declaration().resources[points_.front().resource]));
        }
        Frame& frame = next_frame();
        begin_execution();
        try {
            for (std::uint32_t i = 0; i < plan_.steps.size(); ++i) {
                recorder_.record(
                    commands, frame.descriptors, families_.front(), i, frame.skipped[i]);
            }
            recorder_.record_exit(commands);
        } catch (...) {
            abandon_execution();
            throw;
        }
        last_ = nullptr; // no times
        times_.clear();
        finish_execution();
    }

    void wait() {
        wait_all();
        if (!last_ || !last_->timestamps) return;
        times_.clear();
        for (std::uint32_t i = 0; i < plan_.submissions.size(); ++i) add_times(*last_, i);
        last_ = nullptr;
    }

    /// Throws once an execution was submitted in part: queues are left between hand-overs, so
    /// nobody knows what is in which state.
    void expect_whole() const {
        if (!broken_) return;
        fail_device("an execution of graph '{}' failed when part of it was submitted to '{}' "
                    "already, so its resources are in no known state; make another executor",
            declaration().name, device_.info().name);
    }

    /// False where the graph needs another plan, and then nothing has changed.
    bool take_recorders(Graph& graph) {
        if (graph.fingerprint() != graph_.fingerprint() || !graph.declaration().misuses.empty()) {
            return false;
        }
        std::vector<ResourceDecl>& fresh = graph.declaration().resources;
        for (ResourceId id = 0; id < fresh.size(); ++id) {
            fresh[id].memory = declaration().resources[id].memory;
        }
        graph_ = std::move(graph); // in place: what refers to graph_ stays valid
        return true;
    }

    void keep_content(Impl& old) {
        old.wait_all();
        resources_.keep_content(old.resources_);
    }

    std::vector<std::byte> read(BufferHandle handle) {
        const ResourceDecl& resource = readable(handle.resource, ResourceKind::buffer);
        return gpu::download(
            device_, *resources_[handle.resource].buffer, 0, resource.buffer.bytes);
    }

    Image read(const ImagePart& image) {
        const ResourceId id = image.handle.resource;
        const ResourceDecl& resource = readable(id, ResourceKind::image);
        const gpu::FormatInfo* format = gpu::find_format(resource.image.format);
        if (!format || resource.image.depth > 1) {
            fail_graph(declaration(), "unreadable", "{} of format {} and depth {} is no picture",
                describe(resource), gpu::name_of(resource.image.format), resource.image.depth);
        }
        const VkImageLayout layout = resources_.layout(id);
        if (layout == VK_IMAGE_LAYOUT_UNDEFINED) {
            fail_graph(declaration(), "not-executed",
                "{} cannot be read: what is bound to it now has no content before execute()",
                describe(resource));
        }
        const gpu::Image& real = *resources_[id].image;
        const Part& part = image.part;
        return to_image(gpu::mip_extent(real.info(), part.first_mip), *format,
            gpu::decode_texels(
                *format, gpu::download(device_, real, layout, part.first_layer, part.first_mip)));
    }

    std::vector<SavedResource> save() {
        expect_whole();
        wait();
        std::vector<SavedResource> saved;
        for (const ResourceId id : resources_.persistent()) {
            saved.push_back({declaration().resources[id].name, resources_.content(id)});
        }
        return saved;
    }

    void restore(const std::vector<SavedResource>& saved) {
        expect_whole();
        wait();
        const std::vector<ResourceId> ids = resources_.persistent();
        if (saved.size() != ids.size()) {
            fail_graph(declaration(), "content-mismatch",
                "the graph keeps {} persistent resources, but {} were saved", ids.size(),
                saved.size());
        }
        for (std::size_t i = 0; i < ids.size(); ++i) {
            const ResourceDecl& resource = declaration().resources[ids[i]];
            if (resource.name != saved[i].name) {
                fail_graph(declaration(), "content-mismatch", "'{}' was saved in place of {}",
                    saved[i].name, describe(resource));
            }
            resources_.set_content(ids[i], saved[i].bytes);
        }
    }

    gpu::Device& device() const { return device_; }
    const Policy& policy() const { return policy_; }
    const ExecutorOptions& options() const { return options_; }
    const Graph& graph() const { return graph_; }
    const Plan& plan() const { return plan_; }
    const std::vector<PassTime>& times() const { return times_; }
    std::size_t pipeline_count() const { return recorder_.pipeline_count(); }

private:
    const Declaration& declaration() const { return graph_.declaration(); }
    bool pretends() const { return !options_.pretended_families.empty(); }

    void expect_verified() const {
        if (!options_.verify) return;
        const std::string text =
            violations_text(verify(declaration(), plan_, capabilities_for(device_, options_)));
        if (text.empty()) return;
        fail_graph(declaration(), "bad-plan",
            "the plan does not do what is declared; this is a mistake of the compiler, or of who "
            "changed the plan:\n{}",
            text);
    }

    bool consents(GuardId guard) const {
        for (; guard != kNone; guard = declaration().guards[guard].parent) {
            const Guard& link = declaration().guards[guard];
            if (static_cast<bool>(answers_[link.condition]) != link.wanted) return false;
        }
        return true;
    }

    /// The frame whose execution is the longest ago, ready to record.
    Frame& next_frame() {
        Frame& frame = *frames_[next_];
        submitter_.wait(frame);
        frame.reset();
        frame.skipped.clear();
        for (const Step& step : plan_.steps) {
            frame.skipped.push_back(!consents(declaration().passes[step.pass].guard));
        }
        return frame;
    }

    void begin_execution() {
        resources_.rotate(1); // at first zeros among zeros, into the states of a later execution
    }
    void abandon_execution() { resources_.rotate(-1); }
    void finish_execution() {
        resources_.finish();
        points_.clear();
        executed_ = true;
        next_ = (next_ + 1) % frames_.size();
    }

    void wait_all() {
        for (std::size_t i = 0; i < frames_.size(); ++i) {
            submitter_.wait(*frames_[(next_ + i) % frames_.size()]);
        }
    }

    /// Timestamps of a submission: one before it and one after each of its steps.
    static std::uint32_t first_timestamp(const Submission& submission, std::uint32_t index) {
        return submission.first_step + index;
    }

    bool times_on(const Submission& submission) const {
        const gpu::FamilyInfo& family =
            device_.families()[submitter_.queue(submission.queue).family];
        return family.timestamp_bits > 0 && family.compute && submission.step_count > 0;
    }

    /// `split`: each step in a command buffer of its own.
    void record_submission(Frame& frame, std::uint32_t index, bool timed, bool split) {
        const Submission& submission = plan_.submissions[index];
        CommandBuffers& buffers = *frame.commands[submission.queue];
        const std::uint32_t timestamp = first_timestamp(submission, index);
        timed = timed && times_on(submission);
        VkCommandBuffer commands = buffers.begin();
        if (timed) {
            frame.timestamps->reset(commands, timestamp, submission.step_count + 1);
            frame.timestamps->write(commands, timestamp);
        }
        for (std::uint32_t i = 0; i < submission.step_count; ++i) {
            const std::uint32_t step = submission.first_step + i;
            if (split && i > 0) commands = buffers.begin();
            recorder_.record(commands, frame.descriptors, families_[submission.queue], step,
                frame.skipped[step]);
            if (timed) frame.timestamps->write(commands, timestamp + i + 1);
        }
        if (index + 1 < plan_.submissions.size() || plan_.exit_barrier_count == 0) return;
        if (split) commands = buffers.begin();
        recorder_.record_exit(commands);
    }

    void add_times(const Frame& frame, std::uint32_t index) {
        const Submission& submission = plan_.submissions[index];
        std::vector<double> nanoseconds(submission.step_count + 1, 0);
        if (times_on(submission)) {
            nanoseconds = frame.timestamps->read(first_timestamp(submission, index),
                submission.step_count + 1, submitter_.queue(submission.queue).family);
        }
        for (std::uint32_t i = 0; i < submission.step_count; ++i) {
            const std::uint32_t step = submission.first_step + i;
            times_.push_back({declaration().passes[plan_.steps[step].pass].name,
                (nanoseconds[i + 1] - nanoseconds[i]) * 1e-6, frame.skipped[step] != 0});
        }
    }

    const ResourceDecl& readable(ResourceId id, ResourceKind kind) {
        check(id < declaration().resources.size() && declaration().resources[id].kind == kind,
            "read() of a handle that is not of this graph");
        expect_whole();
        wait();
        const ResourceDecl& resource = declaration().resources[id];
        if (plan_.resources[id].culled) {
            fail_graph(declaration(), "not-kept", "{} cannot be read: it is culled, {}",
                describe(resource), reason_of_resource(declaration(), plan_, id));
        }
        if (resource.lifetime == Lifetime::transient && !resource.exported) {
            fail_graph(declaration(), "not-kept",
                "{} cannot be read: its memory is not kept; export it", describe(resource));
        }
        if (!executed_ && resource.lifetime != Lifetime::persistent) {
            fail_graph(declaration(), "not-executed", "{} cannot be read before execute()",
                describe(resource));
        }
        return resource;
    }

    gpu::Device& device_;
    Policy policy_;
    ExecutorOptions options_;
    Graph graph_;
    Plan plan_;
    std::vector<std::uint8_t> answers_; ///< by ConditionId
    Resources resources_;
    Recorder recorder_;
    Submitter submitter_;
    std::vector<QueueFamily> families_; ///< by Plan::queues, as planned for
    std::vector<std::unique_ptr<Frame>> frames_;
    std::size_t next_ = 0;        ///< frame of the next execution
    const Frame* last_ = nullptr; ///< of the last execution, until its times are read
    bool executed_ = false;
    bool broken_ = false;             ///< an execution was submitted in part
    std::vector<ImportPoint> points_; ///< for the next execution
    std::vector<PassTime> times_;
};

Executor::Executor(
    gpu::Device& device, Graph graph, const Policy& policy, const ExecutorOptions& options) {
    Plan plan = make_plan(device, graph, policy, capabilities_for(device, options), options.plans);
    impl_ = std::make_unique<Impl>(device, std::move(graph), std::move(plan), policy, options);
}

Executor::Executor(gpu::Device& device, Graph graph, Plan plan, const ExecutorOptions& options,
    const Policy& policy)
    : impl_(std::make_unique<Impl>(device, std::move(graph), std::move(plan), policy, options)) {}

Executor::~Executor() = default;
Executor::Executor(Executor&&) noexcept = default;
Executor& Executor::operator=(Executor&&) noexcept = default;

void Executor::bind(BufferHandle handle, const gpu::Buffer& buffer, const ImportSync& sync) {
    impl_->bind(handle, buffer, sync);
}
void Executor::bind(ImageHandle handle, const gpu::Image& image, const ImportSync& sync) {
    impl_->bind(handle, image, sync);
}
void Executor::set(Condition condition, bool value) { impl_->set(condition, value); }
void Executor::execute() {
    impl_->submit();
    impl_->wait();
}
void Executor::submit() { impl_->submit(); }
void Executor::wait() { impl_->wait(); }
void Executor::record(VkCommandBuffer commands) { impl_->record(commands); }
const std::vector<PassTime>& Executor::times() const { return impl_->times(); }

bool Executor::update(Graph graph) {
    impl_->expect_whole();
    if (impl_->take_recorders(graph)) return true;
    gpu::Device& device = impl_->device();
    Plan plan = make_plan(device, graph, impl_->policy(),
        capabilities_for(device, impl_->options()), impl_->options().plans);
    auto fresh = std::make_unique<Impl>(
        device, std::move(graph), std::move(plan), impl_->policy(), impl_->options());
    fresh->keep_content(*impl_);
    impl_ = std::move(fresh);
    return false;
}

std::vector<std::byte> Executor::read(BufferHandle buffer) { return impl_->read(buffer); }
Image Executor::read(const ImagePart& image) { return impl_->read(image); }
std::vector<SavedResource> Executor::save() { return impl_->save(); }
void Executor::restore(const std::vector<SavedResource>& saved) { impl_->restore(saved); }
const Graph& Executor::graph() const { return impl_->graph(); }
const Plan& Executor::plan() const { return impl_->plan(); }
std::size_t Executor::pipeline_count() const { return impl_->pipeline_count(); }

} // namespace ockham
