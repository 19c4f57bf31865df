#include "base/atomic_file.hpp"

#include <unistd.h>

#include <atomic>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace togishi {

namespace fs = std::filesystem;

AtomicFile::AtomicFile(fs::path target) : target_(std::move(target)) {
    static std::atomic<unsigned> serial{0};
    const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
    std::error_code error;
    if (!fs::is_directory(folder, error)) {
        throw InputError(target_.string(), "output folder", "missing: " + folder.string(),
                         "an existing folder");
    }
    if (access(folder.c_str(), W_OK) != 0) {
        throw InputError(target_.string(), "output folder", "read-only: " + folder.string(),
                         "a folder that you may write to");
    }
    temporary_ = folder / ("." + target_.stem().string() + "." + std::to_string(getpid()) + "-" +
                           std::to_string(serial++) + ".part" + target_.extension().string());
}

AtomicFile::~AtomicFile() {
    if (committed_) return;
    std::error_code ignored;  // nothing was promised yet, and a destructor must not throw
    fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
    std::error_code error;
    fs::rename(temporary_, target_, error);
    if (error) {
        throw std::runtime_error(target_.string() +
                                 ": could not be put in place: " + error.message());
    }
    committed_ = true;
}

void write_text_file(const fs::path& target, std::string_view text) {
    AtomicFile file(target);
    std::ofstream out(file.path(), std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) {
        throw std::runtime_error(target.string() +
                                 ": could not be written whole (is the disk full?); the file that "
                                 "stood there before is untouched");
    }
    file.commit();
}

}  // namespace togishi
