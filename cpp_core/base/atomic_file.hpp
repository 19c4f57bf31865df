// Files appear whole or not at all: written under a temporary name, then renamed.
#pragma once
#include <filesystem>
#include <string_view>

namespace togishi {

/// A name beside `target` to write to. commit() renames it over the target; without commit() the
/// temporary file is removed and whatever stood at `target` before is left as it was.
class AtomicFile {
  public:
    /// Throws InputError where the folder is missing or cannot be written.
    explicit AtomicFile(std::filesystem::path target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// The temporary name; it keeps the target's extension, since writers choose formats by it.
    [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
    /// Throws std::runtime_error where the rename fails.
    void commit();

  private:
    std::filesystem::path target_;
    std::filesystem::path temporary_;
    bool committed_ = false;
};

/// Writes text to `target` whole or not at all. Throws InputError (unwritable folder) or
/// std::runtime_error (full disk).
void write_text_file(const std::filesystem::path& target, std::string_view text);

}  // namespace togishi
