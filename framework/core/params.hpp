// SPDX-License-Identifier: Apache-2.0
// Parameters declared once: name, help, unit, range, default. The command line, JSON run files,
// and documentation all read this one list (app/cli). No rendering code sees it: values land in
// the plain structs that the declarations point to.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace ockham {

/// One parameter. Built by Params::add and refined by chaining: `.range(1, 8).unit("samples")`.
class Param {
public:
    /// Where the value lives. A bool with no `on_off()` is a plain flag on the command line.
    using Target =
        std::variant<bool*, int*, std::uint64_t*, float*, std::string*, std::vector<std::string>*>;

    /// Inclusive; numbers only. Infinity must be allowed with `high` = infinity. NaN never is.
    Param& range(double low, double high);
    Param& choices(std::vector<std::string> names);
    Param& unit(std::string name);
    /// For bools: takes `on` or `off` instead of being a bare flag.
    Param& on_off();
    /// Listed under this heading in --help.
    Param& group(std::string name);
    /// A one-letter alias ('o' for -o).
    Param& letter(char name);
    /// Given without a flag; lists only.
    Param& positional();
    /// Not written by --dump-config and not read from run files (help, version, paths of this run).
    Param& transient();

    std::string name, help, unit_name, group_name;
    Target target;
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    std::vector<std::string> allowed;
    std::string default_text;
    char alias = 0;
    bool takes_on_off = false;
    bool is_transient = false;
    bool is_positional = false;
    /// True once set by a command line or a run file.
    bool given = false;

    bool is_flag() const { return std::holds_alternative<bool*>(target) && !takes_on_off; }
    bool is_list() const { return std::holds_alternative<std::vector<std::string>*>(target); }
    /// The present value as text, as a command line would give it.
    std::string text() const;
    /// Parses and stores. Throws Error(input) naming the flag, the text found and what is allowed.
    /// Lists append.
    void set(const std::string& text);
};

/// The declared parameters of one program, in order of declaration.
class Params {
public:
    /// `target` holds the default and must outlive this object. References stay valid.
    Param& add(std::string name, Param::Target target, std::string help);
    std::vector<Param*> all() const;
    Param* find(std::string_view name) const;
    /// True if the user gave this parameter.
    bool given(std::string_view name) const;

    /// Every parameter that is not transient, with its present value.
    nlohmann::json to_json() const;
    /// Sets what `json` names and the command line has not. Throws Error(input) naming `where` and
    /// any key that is unknown or has a wrong value.
    void from_json(const nlohmann::json& json, const std::string& where);

private:
    std::vector<std::unique_ptr<Param>> params_;
};

} // namespace ockham
