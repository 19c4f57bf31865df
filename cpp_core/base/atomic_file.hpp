// Files appear whole or not at all: written under a temporary name, then renamed.
#pragma once
#include <filesystem>
#include <fstream>
#include <string_view>

namespace togishi {

/// Throws InputError where the target's folder is missing or cannot be written: to be asked before
/// long work whose result goes there.
void check_output_folder(const std::filesystem::path& target);

/// A name beside `target` to write to. commit() renames it over the target; without commit() the
/// temporary file is removed and whatever stood at `target` before is left as it was.
class AtomicFile {
  public:
    /// Throws as check_output_folder does.
    explicit AtomicFile(std::filesystem::path target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// The temporary name; it keeps the target's extension, since writers choose formats by it.
    [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
    /// Appends to the temporary file. Throws as fail_writing does.
    void write(std::string_view bytes);
    /// Throws InputError: the target was not written whole (a full disk), and why.
    [[noreturn]] void fail_writing(std::string_view reason) const;
    /// Throws InputError where the last bytes find no room or the rename fails (the target is a
    /// folder).
    void commit();

  private:
    void check(bool good) const;
    std::filesystem::path target_;
    std::filesystem::path temporary_;
    std::ofstream out_;
    bool committed_ = false;
};

/// Writes text to `target` whole or not at all. Throws InputError: a folder that cannot be written,
/// a full disk, a target that cannot be replaced.
void write_text_file(const std::filesystem::path& target, std::string_view text);

}  // namespace togishi
