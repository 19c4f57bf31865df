// Parsed user files, kept until the file changes: a light's file is asked for on every redraw.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>

namespace togishi {

/// Thread-safe. T is what one file becomes; failures are not kept.
template <class T>
class FileCache {
  public:
    std::shared_ptr<const T> get(const std::filesystem::path& path,
                                 const std::function<std::shared_ptr<const T>()>& load) {
        std::error_code no_time;
        std::error_code no_size;
        const auto time = std::filesystem::last_write_time(path, no_time);
        const auto size = std::filesystem::file_size(path, no_size);
        if (no_time || no_size) return load();  // which says what is wrong with the file
        const std::string key = path.string();
        {
            const std::lock_guard lock(guard_);
            const auto found = entries_.find(key);
            if (found != entries_.end() && found->second.time == time &&
                found->second.size == size) {
                return found->second.value;
            }
        }
        auto value = load();
        const std::lock_guard lock(guard_);
        if (entries_.size() >= max_entries) entries_.clear();
        entries_[key] = {time, size, value};
        return value;
    }

  private:
    static constexpr std::size_t max_entries = 64;
    struct Entry {
        std::filesystem::file_time_type time;
        std::uintmax_t size = 0;
        std::shared_ptr<const T> value;
    };
    std::mutex guard_;
    std::map<std::string, Entry> entries_;
};

}  // namespace togishi
