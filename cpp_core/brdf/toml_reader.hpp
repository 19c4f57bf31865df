// Reading and writing TOML by the rules of Togishi's own files: every field known, checked, named
// in errors.
#pragma once
#include <set>
#include <string>
#include <string_view>

#include "brdf/material.hpp"

#define TOML_EXCEPTIONS 1
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

#include "base/error.hpp"

namespace togishi::material_file {

/// A number in its shortest form that TOML reads back as the same float.
[[nodiscard]] std::string number_text(double value);
/// A value as it is shown in a message.
[[nodiscard]] std::string text_of(const toml::node& node);
/// A TOML basic string.
[[nodiscard]] std::string quoted(const std::string& text);

struct Source {
    std::string where;
    SourceLines lines;
};

// A table being read: takes its fields one by one, then refuses what is left over.
class Reader {
  public:
    Reader(const toml::table& table, std::string prefix, const Source& source)
        : table_(table), prefix_(std::move(prefix)), source_(source) {}

    [[nodiscard]] const toml::node* find(std::string_view key) {
        known_.insert(std::string(key));
        return table_.get(key);
    }
    [[nodiscard]] const toml::node& require(std::string_view key, std::string_view allowed) {
        const toml::node* node = find(key);
        if (node == nullptr) fail(table_, key, "missing", allowed);
        return *node;
    }
    [[nodiscard]] double number(std::string_view key, double least, double most,
                                std::string_view allowed) {
        const toml::node& node = require(key, allowed);
        return checked_number(node, key, least, most, allowed);
    }
    [[nodiscard]] double checked_number(const toml::node& node, std::string_view key, double least,
                                        double most, std::string_view allowed) const {
        if (!node.is_number()) fail(node, key, text_of(node), allowed);
        const auto value = node.value<double>();
        // Written so that NaN is refused.
        if (!value || !(*value >= least && *value <= most)) fail(node, key, text_of(node), allowed);
        return *value;
    }
    [[nodiscard]] std::string text(std::string_view key, std::string_view allowed, bool optional) {
        const toml::node* node = find(key);
        if (node == nullptr && optional) return {};
        if (node == nullptr) fail(table_, key, "missing", allowed);
        const auto value = node->value_exact<std::string>();
        if (!value) fail(*node, key, text_of(*node), allowed);
        return *value;
    }
    [[nodiscard]] const toml::table& table(std::string_view key) {
        const toml::node& node = require(key, "a table");
        if (!node.is_table()) fail(node, key, text_of(node), "a table");
        return *node.as_table();
    }
    void refuse_unknown() const {
        for (const auto& [key, node] : table_) {
            if (known_.contains(std::string(key.str()))) continue;
            std::string allowed;
            for (const auto& name : known_) allowed += (allowed.empty() ? "" : ", ") + name;
            fail(node, key.str(), "unknown", allowed);
        }
    }
    [[noreturn]] void fail(const toml::node& node, std::string_view key, std::string_view found,
                           std::string_view allowed) const {
        const auto line = node.source().begin.line;
        const bool shown = source_.lines == SourceLines::shown && line > 0;
        const std::string place =
            shown ? source_.where + ":" + std::to_string(line) : source_.where;
        throw InputError(place, prefix_ + std::string(key), found, allowed);
    }

  private:
    const toml::table& table_;
    std::string prefix_;
    const Source& source_;
    std::set<std::string> known_;
};

}  // namespace togishi::material_file
