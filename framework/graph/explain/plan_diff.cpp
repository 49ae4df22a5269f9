// SPDX-License-Identifier: Apache-2.0
#include "framework/graph/explain/plan_diff.hpp"

#include "framework/graph/explain/json_reader.hpp"
#include "framework/graph/explain/words.hpp"

#include <map>

namespace ockham {

namespace {

using nlohmann::json;

/// One plan of unknown origin, by name; `which` is "before" or "after", for errors.
struct Side {
    struct Pass {
        bool culled = false;
        std::string reason;
        std::uint32_t queue = 0;
    };
    struct Resource {
        std::uint64_t bytes = 0;
        std::string reason;
    };
    struct Difference {
        std::uint64_t count = 0;
        std::string reason;
    };
    std::map<std::string, Pass> passes;
    std::map<std::string, Resource> resources; ///< that are kept
    std::map<std::string, Difference> barriers;
    std::vector<std::string> order; ///< of the passes that are executed
    std::map<std::string, std::uint64_t> numbers;

    explicit Side(const json& plan);
};

std::string optional_text(const JsonReader& in, const char* key) {
    return in.has(key) ? in[key].text() : "";
}

/// What makes two barriers of two plans the same one.
std::string barrier_text(const JsonReader& in) {
    const std::string part = optional_text(in, "part");
    std::string text = fmt::format("{} of {}'{}' from '{}' to '{}': {}/{} -> {}/{}",
        in["hazard"].text(), part.empty() ? "" : part + " of ", in["resource"].text(),
        in["from"].text(), in["to"].text(), in["src_stages"].text(), in["src_access"].text(),
        in["dst_stages"].text(), in["dst_access"].text());
    if (in.has("new_layout"))
        text += fmt::format(", {} -> {}", in["old_layout"].text(), in["new_layout"].text());
    return text;
}

Side::Side(const json& plan) {
    const JsonReader in(plan, "bad-plan-file");
    std::map<std::uint64_t, std::string> steps;
    std::uint64_t kept = 0;
    for (const JsonReader& one : in["passes"].items()) {
        Pass& pass = passes[one["name"].text()];
        pass = {one["culled"].yes(), one["reason"].text()};
        kept += !pass.culled;
        if (one.has("step")) steps[one["step"].number()] = one["name"].text();
        if (one.has("queue")) pass.queue = one["queue"].index(std::size_t{1} << 16);
    }
    for (const auto& [step, name] : steps) order.push_back(name);
    for (const JsonReader& one : in["resources"].items())
        if (!one["culled"].yes())
            resources[one["name"].text()] = {one["bytes"].number(), one["reason"].text()};
    for (const JsonReader& one : in["barriers"].items()) {
        Difference& same = barriers[barrier_text(one)];
        ++same.count;
        same.reason = optional_text(one, "reason");
    }
    const JsonReader memory = in["memory"];
    numbers = {{"passes", kept}, {"barriers", in["barriers"].items().size()},
        {"batches", memory["batches"].number()}, {"bytes_peak", memory["bytes_peak"].number()},
        {"bytes_lower_bound", memory["bytes_lower_bound"].number()}};
    for (const char* list : {"submissions", "queues"})
        numbers[list] = in.has(list) ? in[list].items().size() : 1; // plans of before had one
}

json pass_changes(const Side& before, const Side& after) {
    json out;
    for (const char* key : {"added", "removed", "culled", "revived", "moved"})
        out[key] = json::array();
    const auto add = [&](const char* key, const std::string& name, const std::string& reason) {
        out[key].push_back({{"name", name}, {"reason", reason}});
    };
    for (const auto& [name, pass] : after.passes) {
        const auto old = before.passes.find(name);
        if (old == before.passes.end())
            add("added", name, pass.reason);
        else if (old->second.culled != pass.culled)
            add(pass.culled ? "culled" : "revived", name, pass.reason);
        else if (!pass.culled && old->second.queue != pass.queue)
            add("moved", name, fmt::format("from queue {} to {}", old->second.queue, pass.queue));
    }
    for (const auto& [name, pass] : before.passes)
        if (!after.passes.contains(name)) add("removed", name, pass.reason);
    return out;
}

json resource_changes(const Side& before, const Side& after) {
    json out{{"added", json::array()}, {"removed", json::array()}, {"resized", json::array()}};
    for (const auto& [name, now] : after.resources) {
        const auto old = before.resources.find(name);
        if (old == before.resources.end())
            out["added"].push_back({{"name", name}, {"after", now.bytes}, {"reason", now.reason}});
        else if (old->second.bytes != now.bytes)
            out["resized"].push_back(
                {{"name", name}, {"before", old->second.bytes}, {"after", now.bytes}});
    }
    for (const auto& [name, old] : before.resources)
        if (!after.resources.contains(name))
            out["removed"].push_back({{"name", name}, {"before", old.bytes}});
    return out;
}

/// The barriers that `now` has more of than `other`.
json barriers_beyond(const Side& now, const Side& other) {
    json out = json::array();
    for (const auto& [text, barrier] : now.barriers) {
        const auto found = other.barriers.find(text);
        const std::uint64_t known = found == other.barriers.end() ? 0 : found->second.count;
        if (barrier.count > known)
            out.push_back(
                {{"text", text}, {"reason", barrier.reason}, {"count", barrier.count - known}});
    }
    return out;
}

/// "+3", "-12.0 MiB"; empty for no change.
std::string change_text(const json& number, bool bytes) {
    const auto before = number["before"].get<std::uint64_t>();
    const auto after = number["after"].get<std::uint64_t>();
    if (before == after) return {};
    const std::uint64_t change = std::max(before, after) - std::min(before, after);
    return fmt::format(
        "{}{}", after > before ? '+' : '-', bytes ? size_text(change) : fmt::format("{}", change));
}

} // namespace

json plan_diff(const json& before, const json& after) {
    const Side old(before), now(after);
    json out{{"passes", pass_changes(old, now)}, {"resources", resource_changes(old, now)},
        {"barriers",
            {{"added", barriers_beyond(now, old)}, {"removed", barriers_beyond(old, now)}}},
        {"reordered", false}};
    for (const auto& [name, number] : now.numbers)
        out["numbers"][name] = {{"before", old.numbers.at(name)}, {"after", number}};
    // The passes that both execute, in another order.
    const auto common = [](const Side& side, const Side& other) {
        std::vector<std::string> names = side.order;
        std::erase_if(names, [&](const std::string& name) {
            const auto found = other.passes.find(name);
            return found == other.passes.end() || found->second.culled;
        });
        return names;
    };
    out["reordered"] = common(old, now) != common(now, old);
    return out;
}

std::string plan_diff_text(const json& diff) {
    std::vector<std::string> head;
    for (const auto& [key, what] :
        {std::pair{"passes", " passes"}, {"barriers", " barriers"}, {"batches", " batches"},
            {"submissions", " submissions"}, {"queues", " queues"}, {"bytes_peak", ""}}) {
        const std::string change = change_text(diff["numbers"][key], *what == 0);
        if (!change.empty()) head.push_back(change + what);
    }
    std::string lines;
    const auto list = [&](const json& entries, const char* verb, auto line) {
        for (const json& entry : entries) lines += fmt::format("{} {}\n", verb, line(entry));
    };
    const auto text = [](const json& entry, const char* key) {
        return entry[key].get<std::string>();
    };
    const auto bytes = [](const json& entry, const char* key) {
        return size_text(entry[key].get<std::uint64_t>());
    };
    const auto pass = [&](const json& one) {
        return fmt::format("pass '{}': {}", text(one, "name"), text(one, "reason"));
    };
    for (const auto& [key, verb] : {std::pair{"added", "new"}, {"removed", "gone"},
             {"culled", "now culled:"}, {"revived", "no longer culled:"}, {"moved", "moved:"}})
        list(diff["passes"][key], verb, pass);
    if (diff["reordered"].get<bool>()) lines += "passes run in another order\n";
    list(diff["resources"]["added"], "new", [&](const json& one) {
        return fmt::format(
            "resource '{}', {}: {}", text(one, "name"), bytes(one, "after"), text(one, "reason"));
    });
    list(diff["resources"]["removed"], "gone", [&](const json& one) {
        return fmt::format("resource '{}', {}", text(one, "name"), bytes(one, "before"));
    });
    list(diff["resources"]["resized"], "resized:", [&](const json& one) {
        return fmt::format("'{}' from {} to {} ({})", text(one, "name"), bytes(one, "before"),
            bytes(one, "after"), change_text(one, true));
    });
    const auto barrier = [&](const json& one) {
        const auto count = one["count"].get<std::uint64_t>();
        return fmt::format("barrier{}: {}{}", count > 1 ? fmt::format(" ({} times)", count) : "",
            text(one, "text"),
            text(one, "reason").empty() ? "" : fmt::format(" ({})", text(one, "reason")));
    };
    list(diff["barriers"]["added"], "new", barrier);
    list(diff["barriers"]["removed"], "gone", barrier);
    if (head.empty() && lines.empty()) return "no difference\n";
    return fmt::format("{}\n{}{}",
        head.empty() ? "same numbers" : fmt::format("{}", fmt::join(head, ", ")),
        lines.empty() ? "" : "\n", lines);
}

} // namespace ockham
