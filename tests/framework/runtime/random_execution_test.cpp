// SPDX-License-Identifier: Apache-2.0
// Random graphs of everything that can be declared, executed with real kernels under validation.
// What they leave must be, word for word, what a sequential model leaves that knows no plan.
// OCKHAM_SEED=n runs that seed alone and prints its plan; OCKHAM_SEEDS=n runs the first n.
#include "framework/gpu/buffer.hpp"
#include "framework/gpu/image.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/graph/explain/dependencies.hpp"
#include "framework/graph/explain/explain.hpp"
#include "framework/graph/verify.hpp"
#include "framework/runtime/commands.hpp"
#include "framework/runtime/planning.hpp"
#include "tests/framework/graph/random_declaration.hpp"
#include "tests/framework/runtime/sequential_model.hpp"
#include "tests/support/gpu_fixture.hpp"

#include <bit>
#include <cstdlib>
#include <deque>
#include <memory>
#include <optional>

namespace ockham {
namespace {

using test::HashPasses;
using test::SequentialModel;
using Fault = SequentialModel::Fault;

constexpr std::uint32_t kExecutions = 4;

/// A random graph whose passes record HashPasses.
struct RandomProgram {
    /// What recording functions see: they move with the graph, into the executor.
    struct Shared {
        std::optional<HashPasses> passes;
        std::uint32_t execution = 0;
    };
    std::shared_ptr<Shared> shared = std::make_shared<Shared>();
    Graph graph{""};

    explicit RandomProgram(std::uint64_t seed, const Capabilities& capabilities = {}) {
        RandomOptions options;
        options.max_passes = 2u << (seed % 6);
        options.largest_extent = 8;
        options.largest_chunk = 256;
        options.formats = {VK_FORMAT_R32_SFLOAT};
        options.volumes = false;
        options.guards = seed / 6 % 2 == 0;
        options.finish = [this, pass = PassId{0}](PassBuilder& builder) mutable {
            builder.record([state = shared, pass](Commands& commands) {
                state->passes->record(pass, state->execution, commands);
            });
            ++pass;
        };
        graph = std::move(RandomDeclaration(seed, options, capabilities).graph());
        const HashPasses wished(graph.declaration());
        for (PassId pass = 0; pass < wished.declaration().passes.size(); ++pass) {
            if (wished.clears_images(pass)) // which queues beside the main one need not be able to
                graph.declaration().passes[pass].queue = QueueWish::main;
        }
        shared->passes.emplace(graph.declaration());
    }
    const HashPasses& passes() const { return *shared->passes; }
};

std::vector<std::uint32_t> as_words(const std::vector<std::byte>& bytes) {
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), bytes.size());
    return words;
}

/// The words of an image, mip after mip and layer after layer. Layers that nothing defined may have
/// no layout either and are not read.
template <class Read>
std::vector<std::uint32_t> read_layers(
    const ImageDesc& image, const SequentialModel::Content& expected, Read read) {
    std::vector<std::uint32_t> words;
    for (std::uint32_t mip = 0; mip < image.mips; ++mip) {
        const std::size_t texels =
            std::size_t{std::max(image.width >> mip, 1u)} * std::max(image.height >> mip, 1u);
        for (std::uint32_t layer = 0; layer < image.layers; ++layer) {
            const auto first = expected.defined.begin() + static_cast<std::ptrdiff_t>(words.size());
            const bool any = std::find(first, first + static_cast<std::ptrdiff_t>(texels), 1) !=
                             first + static_cast<std::ptrdiff_t>(texels);
            const std::vector<std::uint32_t> part =
                any ? read(mip, layer) : std::vector<std::uint32_t>(texels);
            words.insert(words.end(), part.begin(), part.end());
        }
    }
    return words;
}

/// The resources that a program imports: made, filled, bound, and put back into the state in which
/// the graph wants to find them.
class Imports {
public:
    Imports(gpu::Device& device, const HashPasses& passes, SequentialModel& model)
        : device_(device), declaration_(passes.declaration()) {
        for (ResourceId id = 0; id < declaration_.resources.size(); ++id) {
            const ResourceDecl& resource = declaration_.resources[id];
            if (resource.lifetime != Lifetime::external) continue;
            std::vector<std::uint32_t> words(model.content(id).words.size());
            for (std::size_t i = 0; i < words.size(); ++i) {
                const std::uint32_t hash =
                    test::hash_word(static_cast<std::uint32_t>(977 * id + i));
                words[i] = passes.holds_group_counts(id) ? 1 + hash % 3
                           : resource.kind == ResourceKind::image
                               ? std::bit_cast<std::uint32_t>(test::texel_of(hash))
                               : hash;
            }
            model.set(id, words);
            if (resource.kind == ResourceKind::buffer)
                add_buffer(id, words);
            else
                add_image(id, words);
        }
    }

    bool empty() const { return buffers_.empty() && images_.empty(); }

    /// `left`: as which plan has left them; null before the first execution.
    void bind(Executor& executor, const Plan* left) {
        for (const auto& [id, buffer] : buffers_) {
            if (!left) executor.bind(BufferHandle{id}, buffer);
        }
        for (const auto& [id, image] : images_) {
            const VkImageLayout entry = declaration_.resources[id].entry.layout;
            const VkImageLayout now =
                left ? left->final_states[id].layout : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
            if (left && (left->resources[id].culled || now == entry)) continue;
            if (now != entry && entry != VK_IMAGE_LAYOUT_UNDEFINED)
                change_layout(image, now, entry);
            executor.bind(ImageHandle{id}, image);
        }
    }

    /// The caller's half of what the plan hands over to other queue families: where there is one
    /// family, its layouts.
    void take_over(const Plan& plan) {
        for (const Barrier& barrier : plan.barriers) {
            const bool within_plan = std::ranges::any_of(plan.barriers, [&](const Barrier& other) {
                return other.hazard == Hazard::acquire && other.to == kNone &&
                       other.resource == barrier.resource && other.part == barrier.part;
            });
            if (barrier.hazard != Hazard::release || barrier.to != kNone || within_plan) continue;
            for (const auto& [id, image] : images_)
                if (id == barrier.resource)
                    change_layout(image, barrier.old_layout, barrier.new_layout, barrier.part);
        }
    }

    std::vector<std::uint32_t> read(
        ResourceId id, const Plan& plan, const SequentialModel::Content& expected) const {
        for (const auto& [found, buffer] : buffers_)
            if (found == id) return as_words(gpu::download(device_, buffer, 0, buffer.bytes()));
        for (const auto& [found, image] : images_) {
            if (found != id) continue;
            return read_layers(declaration_.resources[id].image, expected,
                [&, &real = image](std::uint32_t mip, std::uint32_t layer) {
                    return as_words(
                        gpu::download(device_, real, plan.final_states[id].layout, layer, mip));
                });
        }
        return {};
    }

private:
    void add_buffer(ResourceId id, const std::vector<std::uint32_t>& words) {
        constexpr VkBufferUsageFlags usage =
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
            VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
            VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
            VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
        const ResourceDecl& resource = declaration_.resources[id];
        buffers_.emplace_back(
            id, gpu::Buffer(device_,
                    {.bytes = resource.buffer.bytes, .usage = usage, .name = resource.name}));
        gpu::upload(device_, buffers_.back().second, std::as_bytes(std::span(words)));
    }

    void add_image(ResourceId id, const std::vector<std::uint32_t>& words) {
        constexpr VkImageUsageFlags usage =
            VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
            VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
            VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
        const ResourceDecl& resource = declaration_.resources[id];
        const ImageDesc& desc = resource.image;
        const gpu::Image& image =
            images_
                .emplace_back(id, gpu::Image(device_, {.format = desc.format,
                                                          .width = desc.width,
                                                          .height = desc.height,
                                                          .layers = desc.layers,
                                                          .mips = desc.mips,
                                                          .usage = usage,
                                                          .name = resource.name}))
                .second;
        gpu::Uploader uploader(device_);
        std::span<const std::uint32_t> rest(words);
        for (std::uint32_t mip = 0; mip < desc.mips; ++mip)
            for (std::uint32_t layer = 0; layer < desc.layers; ++layer) {
                const VkExtent3D extent = gpu::mip_extent(image.info(), mip);
                const std::size_t texels = std::size_t{extent.width} * extent.height;
                uploader.add(image, layer, mip, std::as_bytes(rest.first(texels)));
                rest = rest.subspan(texels);
            }
        uploader.finish();
    }

    void change_layout(
        const gpu::Image& image, VkImageLayout from, VkImageLayout to, const Part& part = {}) {
        device_.run("giving back an import", [&](VkCommandBuffer commands) {
            VkImageMemoryBarrier2 barrier{};
            barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
            barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
            barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
            barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
            barrier.oldLayout = from;
            barrier.newLayout = to;
            barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
            barrier.image = image.handle();
            barrier.subresourceRange =
                image.subresources({part.first_mip, part.mips, part.first_layer, part.layers});
            VkDependencyInfo info{};
            info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
            info.imageMemoryBarrierCount = 1;
            info.pImageMemoryBarriers = &barrier;
            vkCmdPipelineBarrier2(commands, &info);
        });
    }

    gpu::Device& device_;
    const Declaration& declaration_;
    std::deque<std::pair<ResourceId, gpu::Buffer>> buffers_;
    std::deque<std::pair<ResourceId, gpu::Image>> images_;
};

/// What comparing looked at, over any number of programs.
struct Tally {
    std::uint64_t compared = 0;  ///< words
    std::uint64_t undefined = 0; ///< words with no defined content, which are not compared
    std::uint64_t passes = 0;    ///< that plans kept
};

/// How to execute a program.
struct Setting {
    std::uint64_t seed = 0;
    bool several_queues = false; ///< planned for some, run on one
    SequentialModel::Fault fault = Fault::none;
    /// Changes the plan before it is executed; false: it cannot, so nothing is executed.
    std::function<bool(const Declaration&, Plan&)> mutate = {};
};

/// Executes a program and its model side by side.
class Comparison {
public:
    Comparison(gpu::Device& device, const Setting& setting)
        : device_(device), setting_(setting), capabilities_(capabilities_of(device)) {
        if (setting.several_queues)
            capabilities_.families = RandomSetting(setting.seed).capabilities.families;
    }

    /// The first difference, or "".
    std::string run(Tally& tally) {
        RandomProgram program(
            setting_.seed, setting_.several_queues ? capabilities_ : Capabilities{});
        const HashPasses& passes = program.passes();
        const Declaration& declaration = passes.declaration();
        Plan plan =
            make_plan(device_, program.graph, RandomSetting(setting_.seed).policy, capabilities_);
        if (setting_.mutate && !setting_.mutate(declaration, plan)) return "";
        if (std::getenv("OCKHAM_SEED"))
            fmt::print("{}{}\n", explain(declaration, plan),
                violations_text(verify(program.graph.declaration(), plan, capabilities_)));

        SequentialModel model(passes, setting_.fault);
        Imports imports(device_, passes, model);
        Pcg32 rng(setting_.seed, 3);
        // Without imports, which are given back in between, executions may overlap. The layer
        // forgets reads from one submission to the next, and then finds hazards that are none.
        const bool overlap =
            imports.empty() && rng.below(2) == 0 && device_.validation() != gpu::Validation::sync;
        ExecutorOptions options;
        options.times = false;
        options.poison = rng.below(2) == 0;
        options.slots = overlap ? 2 : 1;
        options.verify = !setting_.mutate;
        if (setting_.several_queues) options.pretended_families = capabilities_.families;
        Executor executor(device_, std::move(program.graph), std::move(plan), options);
        tally.passes += executor.plan().steps.size();
        for (std::uint32_t execution = 0; execution < kExecutions; ++execution) {
            imports.bind(executor, execution > 0 ? &executor.plan() : nullptr);
            program.shared->execution = execution;
            std::vector<bool> answers;
            for (ConditionId id = 0; id < declaration.conditions.size(); ++id) {
                answers.push_back(rng.below(2) == 0);
                executor.set({id}, answers.back());
            }
            executor.submit();
            model.execute(answers);
            if (overlap && execution + 1 < kExecutions) continue;
            executor.wait();
            imports.take_over(executor.plan());
            const std::string difference = compare_all(executor, imports, model, tally);
            if (!difference.empty()) return fmt::format("execution {}: {}", execution, difference);
        }
        if (model.undefined_reads() > 0)
            return fmt::format("passes read {} undefined words", model.undefined_reads());
        return "";
    }

private:
    static std::string compare_all(
        Executor& executor, const Imports& imports, const SequentialModel& model, Tally& tally) {
        const Declaration& declaration = executor.graph().declaration();
        for (ResourceId id = 0; id < declaration.resources.size(); ++id) {
            if (!is_kept(declaration, executor.plan(), id)) continue;
            const SequentialModel::Content& expected = model.content(id);
            const bool external = declaration.resources[id].lifetime == Lifetime::external;
            const std::string difference = compare(declaration.resources[id].name,
                external ? imports.read(id, executor.plan(), expected)
                         : read(executor, id, expected),
                expected, tally);
            if (!difference.empty()) return difference;
        }
        return "";
    }

    /// Whether the outside can see its content after an execution. Of a history that is only where
    /// passes want all of it: a plan makes no age that none of them reads.
    static bool is_kept(const Declaration& declaration, const Plan& plan, ResourceId id) {
        const ResourceDecl& resource = declaration.resources[id];
        if (plan.resources[id].culled) return false;
        if (resource.lifetime == Lifetime::transient) return resource.exported;
        if (resource.history_depth == 0) return true;
        const ResourceId first = id - resource.history_age;
        const ResourceId last = first + resource.history_depth;
        for (ResourceId age = first; age <= last; ++age)
            if (plan.resources[age].culled) return false;
        for (PassId pass = 0; pass < declaration.passes.size(); ++pass)
            for (const Use& use : declaration.uses_of(pass))
                if (plan.passes[pass].culled && writes(use.access) && use.resource >= first &&
                    use.resource <= last)
                    return false;
        return true;
    }

    static std::vector<std::uint32_t> read(
        Executor& executor, ResourceId id, const SequentialModel::Content& expected) {
        const ResourceDecl& resource = executor.graph().declaration().resources[id];
        if (resource.kind == ResourceKind::buffer)
            return test::read_as<std::uint32_t>(executor, BufferHandle{id});
        return read_layers(resource.image, expected, [&](std::uint32_t mip, std::uint32_t layer) {
            const Image image = executor.read(ImageHandle{id}.mip(mip).layer(layer));
            std::vector<std::uint32_t> words;
            for (const float texel : image.plane(0))
                words.push_back(std::bit_cast<std::uint32_t>(texel));
            return words;
        });
    }

    static std::string compare(const std::string& name, const std::vector<std::uint32_t>& found,
        const SequentialModel::Content& expected, Tally& tally) {
        if (found.size() != expected.words.size())
            return fmt::format(
                "'{}' has {} words, expected {}", name, found.size(), expected.words.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            if (!expected.defined[i]) {
                ++tally.undefined;
                continue;
            }
            ++tally.compared;
            if (found[i] != expected.words[i])
                return fmt::format("word {} of '{}' is {:#x}, expected {:#x}", i, name, found[i],
                    expected.words[i]);
        }
        return "";
    }

    gpu::Device& device_;
    Setting setting_;
    Capabilities capabilities_;
};

std::optional<std::uint64_t> number_from(const char* variable) {
    const char* const text = std::getenv(variable);
    if (!text) return std::nullopt;
    return std::strtoull(text, nullptr, 10);
}

class RandomExecutionTest : public test::GpuTest {
protected:
    /// `count` programs, or as many as OCKHAM_SEEDS says, or the one of OCKHAM_SEED. Hazards are
    /// searched for in the first 300 of those for one queue; beyond, only where all is recorded
    /// that is declared: where reads between two writes are missing the layer asks for a little
    /// more than the memory model does, in about one of 300 programs.
    static void run_programs(std::uint64_t count, bool several_queues) {
        gpu::Device core({.validation = gpu::Validation::core});
        const std::optional<std::uint64_t> wanted = number_from("OCKHAM_SEED");
        const std::uint64_t first = wanted.value_or(0);
        const std::uint64_t end = wanted ? first + 1 : number_from("OCKHAM_SEEDS").value_or(count);
        Tally tally;
        std::uint64_t searched = 0;
        for (std::uint64_t seed = first; seed < end; ++seed) {
            SCOPED_TRACE(fmt::format("OCKHAM_SEED={}", seed));
            const bool search =
                !several_queues && (seed < 300 || RandomProgram(seed).passes().makes_all_reads());
            gpu::Device& used = search ? device() : core;
            searched += search;
            try {
                EXPECT_EQ(Comparison(used, {seed, several_queues}).run(tally), "");
            } catch (const std::exception& error) {
                ADD_FAILURE() << error.what();
            }
            for (const std::string& message : used.validation_log().take())
                ADD_FAILURE() << message;
        }
        fmt::print("{} programs ({} searched for hazards), {} passes, {} words compared, {} "
                   "undefined\n",
            end - first, searched, tally.passes, tally.compared, tally.undefined);
        if (!wanted) {
            EXPECT_LE(tally.undefined, tally.compared / 8);
        }
    }

    /// How many of the programs show the mistake; messages of validation do not count.
    static std::uint64_t count_found(std::uint64_t count, Setting setting) {
        Tally tally;
        std::uint64_t found = 0;
        for (setting.seed = 0; setting.seed < count; ++setting.seed) {
            found += !Comparison(device(), setting).run(tally).empty();
            (void)take_messages();
        }
        return found;
    }

    /// What is undefined may be anything, which as numbers of workgroups never ends.
    static bool is_safe(const Declaration& declaration) {
        return std::ranges::none_of(
            declaration.uses, [](const Use& use) { return use.access == Access::indirect; });
    }
};

TEST_F(RandomExecutionTest, EqualsTheModel) { run_programs(300, false); }

/// Plans for up to three families on one queue. The layer of Debian 12 knows no timeline semaphores
/// in its search for hazards, so it does not search here.
TEST_F(RandomExecutionTest, PlansForSeveralQueuesEqualTheModel) { run_programs(100, true); }

TEST_F(RandomExecutionTest, FindsSwappedInputs) {
    EXPECT_GE(count_found(40, {.fault = Fault::swapped_inputs}), 2u);
}

TEST_F(RandomExecutionTest, FindsIgnoredGuards) {
    EXPECT_GE(count_found(60, {.fault = Fault::ignored_guards}), 2u);
}

TEST_F(RandomExecutionTest, FindsHistoriesThatDoNotTurn) {
    EXPECT_GE(count_found(20, {.fault = Fault::still_histories}), 2u);
}

TEST_F(RandomExecutionTest, FindsHistoriesThatTurnBackwards) {
    EXPECT_GE(count_found(30, {.fault = Fault::reversed_histories}), 2u);
}

TEST_F(RandomExecutionTest, FindsStepsInTheWrongOrder) {
    const auto swap = [](const Declaration& declaration, Plan& plan) {
        if (!is_safe(declaration)) return false;
        for (const Dependency& dependency : direct_dependencies(declaration, plan)) {
            if (dependency.hazard != Hazard::read_after_write) continue;
            const auto step_of = [&](PassId pass) {
                return std::ranges::find(plan.steps, pass, &Step::pass);
            };
            std::swap(step_of(dependency.before)->pass, step_of(dependency.after)->pass);
            return true;
        }
        return false;
    };
    EXPECT_GE(count_found(20, {.mutate = swap}), 2u);
}

TEST_F(RandomExecutionTest, FindsMemoryThatTwoUseAtATime) {
    const auto overlap = [](const Declaration& declaration, Plan& plan) {
        if (!is_safe(declaration)) return false;
        for (Placement& a : plan.placements) {
            for (Placement& b : plan.placements) {
                const bool together = a.heap == b.heap && a.offset != b.offset &&
                                      a.bytes >= b.bytes && a.first_step <= b.last_step &&
                                      b.first_step <= a.last_step;
                if (!together || !plan.heaps[a.heap].shared) continue;
                b.offset = a.offset;
                return true;
            }
        }
        return false;
    };
    EXPECT_GE(count_found(40, {.mutate = overlap}), 2u);
}

} // namespace
} // namespace ockham
