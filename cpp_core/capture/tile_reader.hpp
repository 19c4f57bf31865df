// How photographs come in: bands of rows, one number per pixel. Outside Blender OpenImageIO serves
// it (image/photograph_stack.hpp); inside, whatever the caller has. The capture never knows which.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace togishi {

/// Pictures of one size. Signals are linear, full scale = 1; row 0 is the top.
class TileReader {
  public:
    TileReader() = default;
    TileReader(const TileReader&) = delete;
    TileReader& operator=(const TileReader&) = delete;
    virtual ~TileReader() = default;

    [[nodiscard]] virtual std::size_t width() const = 0;
    [[nodiscard]] virtual std::size_t height() const = 0;
    [[nodiscard]] virtual std::size_t images() const = 0;
    /// Variance of the quantisation, at full scale 1: 1/(12 steps^2); 0 for float pictures.
    [[nodiscard]] virtual double quantisation_variance() const = 0;
    /// What the pictures are, for the run's fingerprint: names, sizes, times of change, transfer.
    [[nodiscard]] virtual std::string fingerprint() const = 0;
    /// Rows [begin, end) of one picture into (end - begin) * width numbers; clipped: 1 where the
    /// signal was at least the value. NaN: no sample. May be called at once for different images,
    /// and is fastest from the top down. Throws InputError naming the file: it ends too early.
    virtual void read(std::size_t image, std::size_t begin, std::size_t end, float* values,
                      std::uint8_t* clipped) = 0;
};

}  // namespace togishi
