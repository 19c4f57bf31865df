#include "base/atomic_file.hpp"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace togishi {

namespace fs = std::filesystem;

namespace {

fs::path folder_of(const fs::path& target) {
    return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

}  // namespace

void check_output_folder(const fs::path& target) {
    const fs::path folder = folder_of(target);
    std::error_code error;
    if (!fs::is_directory(folder, error)) {
        throw InputError(target.string(), "output folder", "missing: " + folder.string(),
                         "an existing folder");
    }
    if (access(folder.c_str(), W_OK) != 0) {
        throw InputError(target.string(), "output folder", "read-only: " + folder.string(),
                         "a folder that you may write to");
    }
}

AtomicFile::AtomicFile(fs::path target) : target_(std::move(target)) {
    static std::atomic<unsigned> serial{0};
    check_output_folder(target_);
    temporary_ =
        folder_of(target_) / ("." + target_.stem().string() + "." + std::to_string(getpid()) + "-" +
                              std::to_string(serial++) + ".part" + target_.extension().string());
}

AtomicFile::~AtomicFile() {
    if (committed_) return;
    std::error_code ignored;  // nothing was promised yet, and a destructor must not throw
    fs::remove(temporary_, ignored);
}

void AtomicFile::check(bool good) const {
    if (!good) fail_writing(std::generic_category().message(errno == 0 ? EIO : errno));
}

void AtomicFile::write(std::string_view bytes) {
    errno = 0;  // streams do not say why they fail
    if (!out_.is_open()) out_.open(temporary_, std::ios::binary);
    out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    check(out_.good());
}

void AtomicFile::commit() {
    if (out_.is_open()) {
        errno = 0;
        out_.close();
        check(out_.good());
    }
    std::error_code error;
    fs::rename(temporary_, target_, error);
    if (error) {
        throw InputError(target_.string(), "output", "not to be replaced (" + error.message() + ")",
                         "a new name, or a file that you may replace");
    }
    committed_ = true;
}

void AtomicFile::fail_writing(std::string_view reason) const {
    throw InputError(target_.string(), "output", "not written whole (" + std::string(reason) + ")",
                     "a place with room for it; what stood there before is untouched");
}

void write_text_file(const fs::path& target, std::string_view text) {
    AtomicFile file(target);
    file.write(text);
    file.commit();
}

}  // namespace togishi
