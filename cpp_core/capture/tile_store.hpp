// What a run has finished so far, on disk beside its target, so that a stopped run goes on where it
// was: bands of rows, each with its checksum, under a temporary name that holds the run's
// fingerprint.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace togishi {

class TileStore {
  public:
    /// Opens what an earlier run of the same fingerprint left, or begins anew. Removes what other
    /// runs for the same target left. Throws InputError: a folder that cannot be written, a full
    /// disk.
    TileStore(const std::filesystem::path& target, const std::string& fingerprint,
              std::size_t width, std::size_t height, std::size_t channels, std::size_t band_rows);

    [[nodiscard]] std::size_t width() const { return width_; }
    [[nodiscard]] std::size_t height() const { return height_; }
    [[nodiscard]] std::size_t channels() const { return channels_; }
    [[nodiscard]] std::size_t band_rows() const { return band_rows_; }
    [[nodiscard]] std::size_t bands() const { return (height_ + band_rows_ - 1) / band_rows_; }
    [[nodiscard]] std::size_t rows_of(std::size_t band) const;
    [[nodiscard]] bool finished(std::size_t band) const { return sums_[band] != 0; }
    [[nodiscard]] std::size_t finished_bands() const;
    /// Pixels interleaved: (rows, width, channels).
    void write(std::size_t band, const std::vector<float>& pixels);
    /// Throws InputError where the file no longer holds what was written.
    [[nodiscard]] std::vector<float> read(std::size_t band);
    void remove();
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    [[nodiscard]] std::uint64_t place_of(std::size_t band) const;
    std::filesystem::path path_;
    std::fstream file_;
    std::size_t width_, height_, channels_, band_rows_;
    std::vector<std::uint64_t> sums_;  ///< 0: not there
};

}  // namespace togishi
