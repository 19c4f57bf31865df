// The options of fit and simulation by name: what the command line, Python and messages share.
#pragma once
#include <array>
#include <string_view>
#include <variant>
#include <vector>

#include "fit/fit.hpp"
#include "scan/simulate_scan.hpp"

namespace togishi {

inline constexpr std::array<std::string_view, 3> fit_choice_names{"off", "on", "auto"};

/// One option: its name, what it means, and where it lies.
template <class Options>
struct OptionField {
    std::string_view name;
    std::string_view help;
    std::variant<double Options::*, bool Options::*, int Options::*, std::string Options::*,
                 FitChoice Options::*>
        member;
};

[[nodiscard]] inline const std::vector<OptionField<FitOptions>>& fit_option_fields() {
    static const std::vector<OptionField<FitOptions>> fields{
        {"metal", "Metal, or auto: chosen by evidence (default: as the scans say)",
         &FitOptions::metal},
        {"anisotropy", "Two half widths: off, on or auto", &FitOptions::anisotropy},
        {"haze", "A second, wider lobe: off, on or auto", &FitOptions::haze},
        {"aperture", "Average over source and detector", &FitOptions::aperture},
        {"tilt", "Fit the sample's tilt and the zero of the receive angle", &FitOptions::tilt},
        {"gain", "Fit a factor for each scan", &FitOptions::gain},
        {"pedestal", "Fit stray light", &FitOptions::pedestal},
        {"gain_prior", "Standard deviation of a scan's factor", &FitOptions::gain_prior},
        {"tilt_prior_deg", "Standard deviation of the tilts before the fit",
         &FitOptions::tilt_prior_deg},
        {"receive_offset_prior_deg", "And of the receive angle's zero; 0: exact",
         &FitOptions::receive_offset_prior_deg},
        {"out_of_plane_prior_deg", "And of the detector's way out of the plane; 0: exact",
         &FitOptions::out_of_plane_prior_deg},
        {"unseen_tilt_deg",
         "Standard deviation of a tilt across the plane where the sample was not turned; 0: none",
         &FitOptions::unseen_tilt_deg},
        {"outlier_sigma", "Readings further off are left out; 0: none", &FitOptions::outlier_sigma},
        {"starts", "Starting points, 1 to 64", &FitOptions::starts},
        {"max_iterations", "Steps of each search", &FitOptions::max_iterations}};
    return fields;
}

/// The numbers of a simulation that stand alone.
struct SimulationField {
    std::string_view name;
    std::string_view help;
    double SimulationOptions::*member;
};

[[nodiscard]] inline const std::vector<SimulationField>& simulation_fields() {
    using S = SimulationOptions;
    static const std::vector<SimulationField> fields{
        {"noise_relative", "Noise, share of the signal", &S::noise_relative},
        {"noise_floor", "Noise, share of the peak", &S::noise_floor},
        {"gain_error", "Standard deviation of each scan's factor", &S::gain_error},
        {"source_aperture_deg", "Full angle of the source", &S::source_aperture_deg},
        {"detector_aperture_deg", "Full angle of the detector", &S::detector_aperture_deg},
        {"pedestal", "Stray light, share of the peak", &S::pedestal},
        {"tilt_t_deg", "The normal leans towards T", &S::tilt_t_deg},
        {"tilt_b_deg", "The normal leans towards B", &S::tilt_b_deg},
        {"receive_offset_deg", "Error of the receive angle", &S::receive_offset_deg},
        {"out_of_plane_deg", "The detector beside the plane of incidence", &S::out_of_plane_deg},
        {"saturation", "Share of the peak where readings clip; 0: none", &S::saturation},
        {"haze_share", "Height of a second lobe over the first's", &S::haze_share},
        {"haze_width", "Width of a second lobe over the first's", &S::haze_width},
        {"outlier_share", "Share of wrong readings", &S::outlier_share}};
    return fields;
}

}  // namespace togishi
