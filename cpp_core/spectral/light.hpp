// Light spectra: the shape of a light's power over wavelength. Amounts are the renderer's business.
//
// | name                  | what |
// |-----------------------|------|
// | D65 D55 D50 A E       | CIE illuminants |
// | FL11 LED-B3 LED-RGB1  | CIE fluorescent and LED illuminants |
// | HPS LPS               | high- and low-pressure sodium lamp |
// | daylight:5000         | CIE daylight of a correlated colour temperature, 4000 to 25000 K |
// | blackbody:3200        | Planck's law, 500 to 100000 K |
// | line:589.3            | one wavelength, 400 to 700 nm |
// | csv:/path/to/file.csv | a measured spectrum: wavelength in nm, power; any spacing |
#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "spectral/grid.hpp"
#include "spectral/table_file.hpp"

namespace togishi {

/// The polyline through measured points, zero outside them.
struct TableSpectrum {
    std::vector<double> wavelengths_nm;  ///< strictly increasing, at least two
    std::vector<double> power;           ///< >= 0, the same size
};
/// All power at one wavelength.
struct LineSpectrum {
    double wavelength_nm;
};
/// Planck's law, CODATA 2018 constants; 100 at 560 nm.
struct BlackbodySpectrum {
    double temperature_k;
};
using SpectrumShape = std::variant<TableSpectrum, LineSpectrum, BlackbodySpectrum>;

/// What is known about a light besides its spectrum.
struct LightDescription {
    std::string name;  ///< as find_light takes it
    std::string title;
    std::string source;
    std::string licence;
    std::vector<std::string> notes;  ///< what a reader should know: range shortfalls, resampling
};

class Light {
  public:
    /// Throws InputError where nothing of the spectrum falls into 400 to 700 nm.
    Light(LightDescription description, SpectrumShape shape);

    [[nodiscard]] const LightDescription& description() const { return description_; }
    [[nodiscard]] const SpectrumShape& shape() const { return shape_; }

    /// Mean power per nm that each sample of the grid stands for. Tables finer than the grid are
    /// shared out, so that nothing between samples is missed; a line is split between its two
    /// neighbours in proportion; the rest is read off at the sample.
    [[nodiscard]] std::vector<double> sample(const Grid& grid) const;

    /// Relative power at increasing wavelengths, as tabulated or by the law. A line gives its
    /// power, 1, to the two neighbouring wavelengths in proportion, and nothing where it lies
    /// outside them.
    [[nodiscard]] std::vector<double> power_at(const std::vector<double>& wavelengths_nm) const;

  private:
    LightDescription description_;
    SpectrumShape shape_;
};

inline constexpr std::string_view default_light = "D65";

/// The lights that are files of data/lights, the default first.
[[nodiscard]] const std::vector<std::shared_ptr<const Light>>& builtin_lights();

/// A light by its name as in the table above. User files are kept until they change. Throws
/// InputError that names what exists or what the number may be.
[[nodiscard]] std::shared_ptr<const Light> find_light(std::string_view name);

/// A user's spectrum from the text of its file (see table_file.hpp; metadata optional). A file of
/// one row is a line. Negative power down to -2 % of the peak is a spectrometer's noise: taken as
/// zero, with a note.
[[nodiscard]] Light light_from_csv(std::string_view text, const std::string& where,
                                   const std::string& name);

}  // namespace togishi
