// The shared formulas (shaders/shared) on arrays, in float or in double. A test interface: it lets
// one test feed the same numbers to the GPU and to both compilations of the core. Nothing in the
// product calls it.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <bit>
#include <cstddef>
#include <map>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "brdf/model.hpp"
#include "python/module.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

// Every argument and result of a formula is a scalar, a vector or a struct of them: a row of reals
// in the order of declaration. So a row is copied into them bit by bit, and no formula needs code
// of its own here.
template <class Real, class T>
constexpr std::size_t width_of() {
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(Real) == 0);
    return sizeof(T) / sizeof(Real);
}

template <class Real, class T>
T read(const double*& row) {
    std::array<Real, width_of<Real, T>()> reals;
    for (Real& real : reals) real = static_cast<Real>(*row++);
    return std::bit_cast<T>(reals);
}

template <class Real, class T>
void write(const T& value, double* row) {
    const auto reals = std::bit_cast<std::array<Real, width_of<Real, T>()>>(value);
    for (std::size_t i = 0; i < reals.size(); ++i) row[i] = static_cast<double>(reals[i]);
}

struct Formula {
    std::size_t input_width = 0;
    std::size_t output_width = 0;
    void (*evaluate)(const double* inputs, double* outputs, std::size_t count) = nullptr;
};

template <class Real, auto function, class Result, class... Arguments>
constexpr Formula erased(Result (* /*deduces the types*/)(Arguments...)) {
    Formula formula;
    formula.input_width = (width_of<Real, Arguments>() + ...);
    formula.output_width = width_of<Real, Result>();
    formula.evaluate = [](const double* inputs, double* outputs, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            // Braces: the arguments are read from left to right.
            const std::tuple<Arguments...> arguments{read<Real, Arguments>(inputs)...};
            write<Real>(std::apply(function, arguments), outputs);
            outputs += width_of<Real, Result>();
        }
    };
    return formula;
}

struct Precisions {
    Formula single_precision;
    Formula double_precision;
};

#define TOGISHI_FORMULA(name)                                                             \
    {                                                                                     \
#name, {                                                                          \
            erased<float, &f32::name>(&f32::name), erased<double, &f64::name>(&f64::name) \
        }                                                                                 \
    }

const std::map<std::string, Precisions>& all_formulas() {
    static const std::map<std::string, Precisions> formulas{
        TOGISHI_FORMULA(fresnel_conductor),
        TOGISHI_FORMULA(fresnel_table_position),
        TOGISHI_FORMULA(fresnel_table_cosine),
        TOGISHI_FORMULA(sanitise_lobe),
        TOGISHI_FORMULA(sanitise_mu_rad),
        TOGISHI_FORMULA(lobe_from_mu),
        TOGISHI_FORMULA(lobe_axes),
        TOGISHI_FORMULA(lobe_shape),
        TOGISHI_FORMULA(lobe_form),
        TOGISHI_FORMULA(lobe_moments),
        TOGISHI_FORMULA(lobe_from_moments),
        TOGISHI_FORMULA(lobe_form_isotropic),
        TOGISHI_FORMULA(lobe_value),
        TOGISHI_FORMULA(lobe_normalised_weight),
        TOGISHI_FORMULA(shadowing_over_cos_r),
        TOGISHI_FORMULA(tangent_frame),
        TOGISHI_FORMULA(fold_normal),
        TOGISHI_FORMULA(unfold_normal),
        TOGISHI_FORMULA(smooth_frame),
        TOGISHI_FORMULA(atan_over_x),
        TOGISHI_FORMULA(coarse_normal),
        TOGISHI_FORMULA(coarse_sum),
        TOGISHI_FORMULA(plain_cross),
        TOGISHI_FORMULA(half_angle),
        TOGISHI_FORMULA(facet_stretch),
        TOGISHI_FORMULA(facet_of),
        TOGISHI_FORMULA(facet_isotropic),
        TOGISHI_FORMULA(light_geometry_at),
        TOGISHI_FORMULA(light_geometry),
        TOGISHI_FORMULA(ji_reflection),
        TOGISHI_FORMULA(hamon_reflection),
        TOGISHI_FORMULA(sanitise_share),
        TOGISHI_FORMULA(blend_reflection),
        TOGISHI_FORMULA(light_point_intensity),
        TOGISHI_FORMULA(light_distance_falloff),
        TOGISHI_FORMULA(light_spot_blend),
        TOGISHI_FORMULA(plain_diffuse),
        TOGISHI_FORMULA(plain_gloss),
    };
    return formulas;
}

#undef TOGISHI_FORMULA

const Precisions& formula_named(const std::string& name) {
    const auto found = all_formulas().find(name);
    if (found == all_formulas().end()) {
        throw InputError("formulas()", "name", name,
                         "a function of shaders/shared (formula_names())");
    }
    return found->second;
}

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

Rows evaluate(const std::string& name, const std::string& precision, const Rows& inputs) {
    const Precisions& both = formula_named(name);
    if (precision != "f32" && precision != "f64") {
        throw InputError("formulas()", "precision", precision, "f32 or f64");
    }
    const Formula& formula = precision == "f32" ? both.single_precision : both.double_precision;
    if (inputs.ndim() != 2 || static_cast<std::size_t>(inputs.shape(1)) != formula.input_width) {
        throw InputError("formulas()", "inputs", std::to_string(inputs.ndim()) + " dimensions",
                         "an array (N, " + std::to_string(formula.input_width) + ")");
    }
    const auto count = static_cast<std::size_t>(inputs.shape(0));
    Rows outputs({count, formula.output_width});
    const double* from = inputs.data();
    double* to = outputs.mutable_data();
    {
        const py::gil_scoped_release unlocked;
        formula.evaluate(from, to, count);
    }
    return outputs;
}

std::vector<std::string> names() {
    std::vector<std::string> result;
    for (const auto& [name, formula] : all_formulas()) result.push_back(name);
    return result;
}

}  // namespace

void bind_formulas(py::module_& m) {
    m.def("formula_names", &names,
          "Names of the functions of shaders/shared that formulas() evaluates.");
    m.def("formulas", &evaluate, py::arg("name"), py::arg("precision"), py::arg("inputs"),
          "One shared formula on rows of numbers, in float (f32) or double (f64). For tests.");
}

}  // namespace togishi
