#include "scan/scan_file.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "base/error.hpp"
#include "base/sha256.hpp"
#include "base/text.hpp"
#include "scan/scan_channel.hpp"
#include "spectral/light.hpp"
#include "spectral/metal.hpp"

namespace togishi {

std::size_t ScanSet::rows() const {
    return std::accumulate(
        scans.begin(), scans.end(), std::size_t{0},
        [](std::size_t sum, const Scan& scan) { return sum + scan.rows.size(); });
}

std::size_t ScanSet::readings() const {
    std::size_t sum = 0;
    for (const Scan& scan : scans) {
        sum += static_cast<std::size_t>(std::count_if(scan.intensity.begin(), scan.intensity.end(),
                                                      [](double v) { return !std::isnan(v); }));
    }
    return sum;
}

namespace {

constexpr std::string_view format_value = "togishi-scan 1";
constexpr double gap = std::numeric_limits<double>::quiet_NaN();
constexpr double deg_per_rad = 57.295779513082320877;

constexpr std::array<std::string_view, 16> header_keys{"format",
                                                       "part",
                                                       "quantity",
                                                       "calibration",
                                                       "unit",
                                                       "source_aperture_deg",
                                                       "detector_aperture_deg",
                                                       "turn_sense",
                                                       "metal",
                                                       "light",
                                                       "blade_axis_deg",
                                                       "saturation",
                                                       "name",
                                                       "instrument",
                                                       "date",
                                                       "note"};

std::string list_of(auto const& names) {
    std::string all;
    for (const auto& name : names) all += (all.empty() ? "" : ", ") + std::string(name);
    return all;
}

std::string place(const std::string& where, std::size_t line) {
    return where + ", line " + std::to_string(line);
}

// Insertions, deletions and replacements that make one of the other: finds misspelt keys.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t above = row[j + 1];
            row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
            diagonal = above;
        }
    }
    return row.back();
}

struct HeaderValue {
    std::string text;
    std::string where;  // file and line, or the setting
};

// The header's keys and, over them, what the user said.
class Header {
  public:
    explicit Header(std::string where) : where_(std::move(where)) {}

    void add_line(std::string_view comment, std::size_t line, std::vector<std::string>& notes) {
        const auto colon = comment.find(':');
        if (colon == std::string_view::npos) return;
        const std::string key(trim(comment.substr(0, colon)));
        constexpr std::size_t longest_key = 40;
        if (key.empty() || key.size() > longest_key ||
            key.find_first_of(" \t") != std::string_view::npos)
            return;
        if (std::find(header_keys.begin(), header_keys.end(), key) == header_keys.end()) {
            for (const auto known : header_keys) {
                if (edit_distance(key, known) <= 2 && key.size() > 3) {
                    throw InputError(place(where_, line), "header key", shown(key), known);
                }
            }
            notes.push_back(place(where_, line) + ": " + shown(key) +
                            " is no key of this format and was taken as a comment");
            return;
        }
        const bool first =
            values_
                .try_emplace(key, HeaderValue{std::string(trim(comment.substr(colon + 1))),
                                              place(where_, line)})
                .second;
        if (!first && key != "note") {
            throw InputError(place(where_, line), key, "stated twice", "each key once");
        }
    }
    void set(const ScanSettings& settings, std::vector<std::string>& notes) {
        for (const auto& [key, text] : settings) {
            if (std::find(header_keys.begin(), header_keys.end(), key) == header_keys.end()) {
                throw InputError("settings", "key", shown(key), list_of(header_keys));
            }
            const auto found = values_.find(key);
            if (found != values_.end() && found->second.text != text) {
                notes.push_back(where_ + ": " + key + " is " + shown(text) +
                                " as told; the file says " + shown(found->second.text));
            }
            values_.insert_or_assign(key, HeaderValue{text, "setting of " + where_});
            told_.insert(key);
        }
    }
    [[nodiscard]] bool told(std::string_view key) const { return told_.contains(key); }
    [[nodiscard]] const HeaderValue* find(std::string_view key) const {
        const auto found = values_.find(key);
        return found == values_.end() || found->second.text.empty() ? nullptr : &found->second;
    }
    [[nodiscard]] const HeaderValue& require(std::string_view key,
                                             const std::string& allowed) const {
        if (const HeaderValue* value = find(key)) return *value;
        throw InputError(
            where_, key, "missing",
            "a line \"# " + std::string(key) + ": ...\" in the header (" + allowed + ")");
    }
    template <class Names>
    [[nodiscard]] std::size_t choice(std::string_view key, const Names& names) const {
        const HeaderValue& value = require(key, list_of(names));
        const auto found = std::find(names.begin(), names.end(), value.text);
        if (found == names.end()) {
            throw InputError(value.where, key, shown(value.text), list_of(names));
        }
        return static_cast<std::size_t>(found - names.begin());
    }
    [[nodiscard]] double number(std::string_view key, double least, double most,
                                const std::string& allowed) const {
        const HeaderValue& value = require(key, allowed);
        std::string text = value.text;
        std::replace(text.begin(), text.end(), ',', '.');
        const auto parsed = parse_number(text);
        if (!parsed || !(*parsed >= least && *parsed <= most)) {
            throw InputError(value.where, key, shown(value.text), allowed);
        }
        return *parsed;
    }
    [[nodiscard]] const std::string& where() const { return where_; }

  private:
    std::string where_;
    std::map<std::string, HeaderValue, std::less<>> values_;
    std::set<std::string, std::less<>> told_;
};

enum class Angle { incidence, receive, turn, azimuth };
constexpr std::array<std::string_view, 4> angle_names{"incidence", "receive", "turn", "azimuth"};

struct Columns {
    char separator = ',';
    std::size_t line = 0;  // of the titles
    std::vector<std::string> titles;
    std::array<int, 4> angle{-1, -1, -1, -1};
    double deg_per_unit = 1;
    std::vector<ScanChannel> channels;
    std::vector<int> intensity, sigma;  // column of each channel; -1: not there
};

std::vector<std::string_view> split(std::string_view line, char separator) {
    std::vector<std::string_view> fields;
    while (true) {
        const auto end = line.find(separator);
        fields.push_back(trim(line.substr(0, end)));
        if (end == std::string_view::npos) return fields;
        line.remove_prefix(end + 1);
    }
}

std::string column_name(const Columns& columns, std::size_t c) {
    return "column " + std::to_string(c + 1) +
           (c < columns.titles.size() ? " (" + columns.titles[c] + ")" : "");
}

void place_angle(Columns& columns, std::size_t c, const std::string& at, std::string& first_unit) {
    const std::string& title = columns.titles[c];
    const std::string unit = title.substr(title.size() - 3);
    const std::string_view name = std::string_view(title).substr(0, title.size() - 4);
    const auto which =
        std::find(angle_names.begin(), angle_names.end(), name) - angle_names.begin();
    int& column = columns.angle[static_cast<std::size_t>(which)];
    if (column >= 0) throw InputError(at, column_name(columns, c), "a second time", "each once");
    column = static_cast<int>(c);
    if (first_unit.empty()) first_unit = unit;
    if (unit != first_unit) {
        throw InputError(at, column_name(columns, c), "mixed units (" + unit + ")",
                         "all angles in " + first_unit);
    }
    columns.deg_per_unit = unit == "rad" ? deg_per_rad : 1.0;
}

Columns columns_of(std::string_view line, std::size_t number, const std::string& where) {
    Columns columns;
    columns.line = number;
    columns.separator = line.find(';') != std::string_view::npos    ? ';'
                        : line.find('\t') != std::string_view::npos ? '\t'
                                                                    : ',';
    const std::string at = place(where, number);
    for (auto field : split(line, columns.separator)) {
        if (field.size() > 1 && field.front() == '"' && field.back() == '"')
            field = field.substr(1, field.size() - 2);
        columns.titles.emplace_back(field);
    }
    const auto is_angle = [](std::string_view title) {
        for (const auto name : angle_names) {
            if (title == std::string(name) + "_deg" || title == std::string(name) + "_rad")
                return true;
        }
        return false;
    };
    std::string unit;
    std::map<std::string, int> sigmas;
    constexpr std::size_t most_channels = 64;
    for (std::size_t c = 0; c < columns.titles.size(); ++c) {
        const std::string& title = columns.titles[c];
        const auto channel = parse_channel(title);
        if (is_angle(title)) {
            place_angle(columns, c, at, unit);
        } else if (channel) {
            if (std::find(columns.channels.begin(), columns.channels.end(), *channel) !=
                columns.channels.end()) {
                throw InputError(at, column_name(columns, c), "a second time", "each once");
            }
            columns.channels.push_back(*channel);
            columns.intensity.push_back(static_cast<int>(c));
        } else if (title.starts_with("sigma")) {
            sigmas.emplace(title, static_cast<int>(c));
        } else {
            const bool number_there = parse_number(title).has_value();
            throw InputError(
                at, "column " + std::to_string(c + 1),
                shown(title) + (number_there ? " (a row before any titles?)" : ""),
                "a title: incidence_deg, receive_deg, turn_deg, azimuth_deg (or _rad), "
                "intensity, intensity_550nm, intensity_r, ... or sigma, ...");
        }
    }
    if (columns.channels.size() > most_channels) {
        throw InputError(at, "intensity columns", std::to_string(columns.channels.size()),
                         "at most " + std::to_string(most_channels));
    }
    for (const Angle needed : {Angle::incidence, Angle::receive}) {
        if (columns.angle[static_cast<std::size_t>(needed)] < 0) {
            throw InputError(at,
                             std::string(angle_names[static_cast<std::size_t>(needed)]) + "_deg",
                             "missing", "a column of this title");
        }
    }
    if (columns.channels.empty()) {
        throw InputError(at, "intensity", "missing",
                         "a column of this title, or intensity_550nm, ...");
    }
    for (const ScanChannel& channel : columns.channels) {
        const auto found =
            sigmas.find("sigma" + channel.name.substr(std::string_view("intensity").size()));
        columns.sigma.push_back(found == sigmas.end() ? -1 : found->second);
        if (found != sigmas.end()) sigmas.erase(found);
    }
    if (!sigmas.empty()) {
        throw InputError(at, column_name(columns, static_cast<std::size_t>(sigmas.begin()->second)),
                         "without its intensity",
                         "sigma beside intensity, sigma_550nm beside intensity_550nm");
    }
    const auto stated =
        std::count_if(columns.sigma.begin(), columns.sigma.end(), [](int c) { return c >= 0; });
    if (stated != 0 && static_cast<std::size_t>(stated) != columns.sigma.size()) {
        throw InputError(at, "sigma", "stated for some channels only", "for all, or for none");
    }
    return columns;
}

// Numbers of a file have one decimal sign: which one, its first fraction says.
class NumberReader {
  public:
    NumberReader(const Columns& columns, const std::string& where)
        : columns_(columns), where_(where) {}

    // A gap is NaN.
    double read(std::string_view field, std::size_t column, std::size_t line, bool gap_allowed) {
        if (field.empty() || field == "nan" || field == "NaN" || field == "NAN" || field == "-" ||
            field == "NA") {
            if (gap_allowed) return gap;
            fail(field, column, line, "a number (an angle cannot be missing)");
        }
        std::string copy;
        if (columns_.separator != ',' && field.find(',') != std::string_view::npos) {
            note_sign(',', field, column, line);
            copy = field;
            std::replace(copy.begin(), copy.end(), ',', '.');
            field = copy;
        } else if (field.find('.') != std::string_view::npos) {
            note_sign('.', field, column, line);
        }
        const auto value = parse_number(field);
        if (!value || !std::isfinite(*value)) fail(field, column, line, "a finite number");
        return *value;
    }
    [[noreturn]] void fail(std::string_view field, std::size_t column, std::size_t line,
                           const std::string& allowed) const {
        throw InputError(place(where_, line), column_name(columns_, column), shown(field), allowed);
    }

  private:
    void note_sign(char sign, std::string_view field, std::size_t column, std::size_t line) {
        if (sign_ == '\0') sign_ = sign;
        if (sign != sign_) {
            fail(field, column, line,
                 std::string("numbers with a decimal ") + (sign_ == ',' ? "comma" : "point") +
                     " as in the rows before, without separators of thousands");
        }
    }
    const Columns& columns_;
    const std::string& where_;
    char sign_ = '\0';
};

struct Row {
    double incidence_deg, turn_deg, receive_deg, azimuth_deg;
    std::size_t line, at;  // at: of its readings
};

struct Rows {
    std::vector<Row> rows;
    std::vector<double> intensity, sigma;
    std::size_t gaps = 0, first_gap = 0;
};

double angle(NumberReader& numbers, const Columns& columns, Angle which,
             const std::vector<std::string_view>& fields, std::size_t line, double least,
             double most) {
    const auto index = static_cast<std::size_t>(which);
    if (columns.angle[index] < 0) return 0;
    const auto c = static_cast<std::size_t>(columns.angle[index]);
    const double value = numbers.read(fields[c], c, line, false) * columns.deg_per_unit;
    if (!(value >= least && value <= most)) {
        numbers.fail(fields[c], c, line,
                     format_number(least) + " to " + format_number(most) + " degrees");
    }
    return value;
}

void add_row(Rows& rows, NumberReader& numbers, const Columns& columns,
             const std::vector<std::string_view>& fields, std::size_t line) {
    Row row{};
    row.incidence_deg = angle(numbers, columns, Angle::incidence, fields, line, 0, 89.9);
    row.receive_deg = angle(numbers, columns, Angle::receive, fields, line, -89.9, 89.9);
    row.turn_deg = angle(numbers, columns, Angle::turn, fields, line, -360, 360);
    row.azimuth_deg = angle(numbers, columns, Angle::azimuth, fields, line, -180, 180);
    row.line = line;
    row.at = rows.intensity.size();
    bool any = false;
    for (std::size_t c = 0; c < columns.channels.size(); ++c) {
        const auto column = static_cast<std::size_t>(columns.intensity[c]);
        const double value = numbers.read(fields[column], column, line, true);
        rows.intensity.push_back(value);
        any = any || !std::isnan(value);
        if (columns.sigma[c] < 0) continue;
        const auto beside = static_cast<std::size_t>(columns.sigma[c]);
        const double sigma = numbers.read(fields[beside], beside, line, std::isnan(value));
        if (!std::isnan(value) && !(sigma > 0)) {
            numbers.fail(fields[beside], beside, line, "a standard deviation above 0");
        }
        rows.sigma.push_back(sigma);
    }
    if (any) {
        rows.rows.push_back(row);
        return;
    }
    rows.intensity.resize(row.at);
    if (!rows.sigma.empty()) rows.sigma.resize(row.at);
    if (rows.gaps++ == 0) rows.first_gap = line;
}

// Whether two readings of one direction can be one: within six sigma, or a tenth.
void check_repeated(const Rows& rows, const Row& a, const Row& b, const Columns& columns,
                    double peak, const std::string& where) {
    for (std::size_t c = 0; c < columns.channels.size(); ++c) {
        const double x = rows.intensity[a.at + c], y = rows.intensity[b.at + c];
        if (std::isnan(x) || std::isnan(y)) continue;
        const double allowed = rows.sigma.empty()
                                   ? 0.1 * std::max(std::abs(x), std::abs(y)) + 0.01 * peak
                                   : 6 * std::hypot(rows.sigma[a.at + c], rows.sigma[b.at + c]);
        if (std::abs(x - y) > allowed) {
            const Row& later = a.line > b.line ? a : b;
            const Row& earlier = a.line > b.line ? b : a;
            throw InputError(place(where, later.line),
                             column_name(columns, static_cast<std::size_t>(columns.intensity[c])),
                             format_number(rows.intensity[later.at + c]) + " where line " +
                                 std::to_string(earlier.line) + ", of the same angles, has " +
                                 format_number(rows.intensity[earlier.at + c]),
                             "readings of one direction that agree");
        }
    }
}

// Angles that were typed are equal to a millionth of a degree.
std::int64_t micro_deg(double deg) {
    return std::llround(deg * 1e6);
}

void check_columns_not_exchanged(const Rows& rows, const Columns& columns,
                                 const std::string& where) {
    std::set<std::int64_t> incidences, receives;
    for (const Row& row : rows.rows) {
        incidences.insert(micro_deg(row.incidence_deg));
        receives.insert(micro_deg(row.receive_deg));
        constexpr std::size_t enough = 200;
        if (receives.size() > enough) break;
    }
    constexpr std::size_t sweep = 20;
    if (incidences.size() >= sweep && incidences.size() > 3 * receives.size()) {
        const int c = columns.angle[static_cast<std::size_t>(Angle::incidence)];
        throw InputError(place(where, columns.line),
                         column_name(columns, static_cast<std::size_t>(c)),
                         std::to_string(incidences.size()) + " incidences with " +
                             std::to_string(receives.size()) + " receive angles",
                         "scans over the receive angle: the two columns look exchanged");
    }
}

// The mirror direction of a light from the left is on the right.
void check_sense_of_receive(const std::vector<Scan>& scans, std::size_t channels,
                            const Columns& columns, const std::string& where) {
    std::size_t reversed = 0, judged = 0;
    const ScanRow* brightest_row = nullptr;
    double incidence = 0;
    for (const Scan& scan : scans) {
        if (scan.incidence_deg < 10) continue;
        double mirror_side = 0, light_side = 0;
        for (std::size_t i = 0; i < scan.rows.size(); ++i) {
            const double value = scan.intensity[i * channels];
            if (std::isnan(value) || std::abs(scan.rows[i].azimuth_deg) > 30) continue;
            double& side = scan.rows[i].receive_deg < 0 ? light_side : mirror_side;
            if (value > side) {
                side = value;
                if (&side == &light_side) {
                    brightest_row = &scan.rows[i];
                    incidence = scan.incidence_deg;
                }
            }
        }
        ++judged;
        if (light_side > 2 * mirror_side && light_side > 0) ++reversed;
    }
    if (2 * reversed > judged && brightest_row != nullptr) {
        const int c = columns.angle[static_cast<std::size_t>(Angle::receive)];
        throw InputError(place(where, brightest_row->line),
                         column_name(columns, static_cast<std::size_t>(c)),
                         "brightest at " + format_number(brightest_row->receive_deg) + " degrees",
                         "receive angles positive on the mirror's side, here brightest near " +
                             format_number(incidence) + ": the sign looks reversed");
    }
}

struct Setup {
    ScanQuantity quantity;
    double source_aperture_deg, detector_aperture_deg, saturation;
};

std::vector<Scan> scans_of(Rows rows, const Columns& columns, const Setup& setup,
                           const std::string& where, std::vector<std::string>& notes) {
    const std::size_t channels = columns.channels.size();
    const auto key = [](const Row& r) {
        return std::array{micro_deg(r.turn_deg), micro_deg(r.incidence_deg),
                          micro_deg(r.azimuth_deg), micro_deg(r.receive_deg)};
    };
    std::stable_sort(rows.rows.begin(), rows.rows.end(),
                     [&](const Row& a, const Row& b) { return key(a) < key(b); });
    double peak = 0;
    for (const double v : rows.intensity) peak = std::max(peak, std::isnan(v) ? 0 : std::abs(v));
    std::size_t repeated = 0;
    std::vector<Scan> scans;
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
        const Row& row = rows.rows[i];
        const bool same_scan =
            i > 0 && micro_deg(rows.rows[i - 1].turn_deg) == micro_deg(row.turn_deg) &&
            micro_deg(rows.rows[i - 1].incidence_deg) == micro_deg(row.incidence_deg);
        if (!same_scan) {
            Scan scan;
            scan.file = where;
            scan.incidence_deg = row.incidence_deg;
            scan.turn_deg = row.turn_deg;
            scan.quantity = setup.quantity;
            scan.source_aperture_deg = setup.source_aperture_deg;
            scan.detector_aperture_deg = setup.detector_aperture_deg;
            scan.saturation = setup.saturation;
            scans.push_back(std::move(scan));
        } else if (key(rows.rows[i - 1]) == key(row)) {
            check_repeated(rows, rows.rows[i - 1], row, columns, peak, where);
            ++repeated;
        }
        Scan& scan = scans.back();
        scan.rows.push_back({row.receive_deg, row.azimuth_deg, row.line});
        for (std::size_t c = 0; c < channels; ++c) {
            scan.intensity.push_back(rows.intensity[row.at + c]);
            if (!rows.sigma.empty()) scan.sigma.push_back(rows.sigma[row.at + c]);
        }
    }
    if (repeated > 0) {
        notes.push_back(where + ": " + std::to_string(repeated) +
                        " directions were read more than once, alike; all readings count");
    }
    if (rows.gaps > 0) {
        notes.push_back(where + ": " + std::to_string(rows.gaps) +
                        " rows without intensity were left out, the first in line " +
                        std::to_string(rows.first_gap));
    }
    return scans;
}

// A name in a file must not make us open another file: paths are for the user to give.
void refuse_path(const Header& header, std::string_view key) {
    const HeaderValue* value = header.find(key);
    if (value == nullptr || header.told(key)) return;
    const bool path =
        value->text.starts_with("csv:") || value->text.find_first_of("/\\.") != std::string::npos;
    const bool number =
        value->text.find(':') != std::string::npos && !value->text.starts_with("csv:");
    if (path && !number) {
        throw InputError(
            value->where, key, shown(value->text),
            "a built-in name; a file of your own is named beside the scan, as a setting");
    }
}

void read_header(ScanSet& set, const Header& header) {
    if (const HeaderValue* format = header.find("format");
        format != nullptr && format->text != format_value) {
        throw InputError(format->where, "format", shown(format->text), format_value);
    }
    set.part = static_cast<ScanPart>(header.choice("part", scan_part_names));
    set.calibration =
        static_cast<ScanCalibration>(header.choice("calibration", scan_calibration_names));
    const bool absolute = set.calibration == ScanCalibration::absolute;
    if (absolute) {
        const HeaderValue& unit = header.require("unit", "1/sr");
        if (unit.text != "1/sr") {
            throw InputError(unit.where, "unit", shown(unit.text),
                             "1/sr where the calibration is absolute");
        }
    }
    const HeaderValue* unit = header.find("unit");
    set.unit = unit == nullptr ? "relative" : unit->text.substr(0, 40);
    for (const std::string_view key : {"metal", "light"}) refuse_path(header, key);
    const HeaderValue* metal = header.find("metal");
    set.metal = metal == nullptr ? "auto" : metal->text;
    if (set.metal != "auto") (void)find_metal(set.metal);
    if (const HeaderValue* light = header.find("light")) set.light = light->text;
    (void)find_light(set.light);
    if (const HeaderValue* name = header.find("name")) set.name = name->text.substr(0, 200);
}

void turn_as_stated(std::vector<Row>& rows, const Header& header) {
    double sense = 1;
    const auto turned = std::find_if(rows.begin(), rows.end(), [](const Row& row) {
        return micro_deg(std::remainder(row.turn_deg, 180.0)) != 0;
    });
    if (turned != rows.end() || header.find("turn_sense") != nullptr) {
        constexpr std::array<std::string_view, 2> senses{"counter-clockwise", "clockwise"};
        sense = header.choice("turn_sense", senses) == 0 ? 1 : -1;
    }
    const double axis = header.find("blade_axis_deg") == nullptr
                            ? 0
                            : header.number("blade_axis_deg", -360, 360, "-360 to 360 degrees");
    for (Row& row : rows) {
        const double turn = std::fmod(sense * row.turn_deg + axis, 360.0);
        row.turn_deg = turn < 0 ? turn + 360.0 : turn;
        // -1e-12 + 360 is 360.
        if (micro_deg(row.turn_deg) == micro_deg(360)) row.turn_deg = 0;
    }
}

void check_agreement(const ScanSet& a, const ScanSet& b) {
    const auto agree = [&](std::string_view field, const std::string& x, const std::string& y) {
        if (x != y) {
            throw InputError(b.inputs.front().file, field, shown(y),
                             shown(x) + " as in " + a.inputs.front().file);
        }
    };
    agree("calibration",
          std::string(scan_calibration_names[static_cast<std::size_t>(a.calibration)]),
          std::string(scan_calibration_names[static_cast<std::size_t>(b.calibration)]));
    agree("unit", a.unit, b.unit);
    agree("metal", a.metal, b.metal);
    agree("light", a.light, b.light);
    const auto titles = [](const ScanSet& set) {
        std::string all;
        for (const ScanChannel& c : set.channels) all += (all.empty() ? "" : ", ") + c.name;
        return all;
    };
    agree("intensity columns", titles(a), titles(b));
}

}  // namespace

ScanSet parse_scans(std::string_view text, const std::string& where, const ScanSettings& settings) {
    ScanSet set;
    set.inputs.push_back({where, sha256_hex(text)});
    text = checked_text(text, where);
    Header header(where);
    std::optional<Columns> columns;
    std::optional<NumberReader> numbers;
    Rows rows;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const auto line = trim(take_line(text));
        if (line.empty()) continue;
        if (line.front() == '#') {
            if (!columns) header.add_line(line.substr(1), number, set.notes);
            continue;
        }
        if (!columns) {
            columns = columns_of(line, number, where);
            numbers.emplace(*columns, where);
            continue;
        }
        const auto fields = split(line, columns->separator);
        if (fields.size() != columns->titles.size()) {
            throw InputError(place(where, number), "row", std::to_string(fields.size()) + " fields",
                             std::to_string(columns->titles.size()) + ", as many as titles" +
                                 (columns->separator == ','
                                      ? " (decimal commas need semicolons or tabs between columns)"
                                      : ""));
        }
        if (rows.rows.size() == scan_file_max_rows) {
            throw InputError(place(where, number), "number of rows",
                             "more than " + std::to_string(scan_file_max_rows),
                             "at most that many");
        }
        add_row(rows, *numbers, *columns, fields, number);
    }
    if (!columns)
        throw InputError(where, "content", "no column titles", "a scan file (docs/measurement.md)");
    if (rows.rows.empty())
        throw InputError(where, "content", "no row with an intensity", "rows of numbers");
    header.set(settings, set.notes);
    read_header(set, header);
    set.channels = columns->channels;
    check_columns_not_exchanged(rows, *columns, where);
    Setup setup{};
    setup.quantity = static_cast<ScanQuantity>(header.choice("quantity", scan_quantity_names));
    const std::string aperture = "full angle, 0 to 20 degrees";
    setup.source_aperture_deg = header.number("source_aperture_deg", 0, 20, aperture);
    setup.detector_aperture_deg = header.number("detector_aperture_deg", 0, 20, aperture);
    setup.saturation = header.find("saturation") == nullptr
                           ? std::numeric_limits<double>::infinity()
                           : header.number("saturation", std::numeric_limits<double>::min(), 1e300,
                                           "the reading above 0 from which the detector clips");
    turn_as_stated(rows.rows, header);
    set.scans = scans_of(std::move(rows), *columns, setup, where, set.notes);
    check_sense_of_receive(set.scans, set.channels.size(), *columns, where);
    return set;
}

std::vector<ScanSet> read_scans(std::span<const std::filesystem::path> files,
                                const ScanSettings& settings) {
    if (files.empty()) throw InputError("scans", "files", "none", "at least one scan file");
    std::vector<ScanSet> sets;
    for (const auto& file : files) {
        ScanSet next =
            parse_scans(read_text_file(file, scan_file_max_bytes, "a scan as CSV or TSV"),
                        file.string(), settings);
        const auto same = std::find_if(sets.begin(), sets.end(),
                                       [&](const ScanSet& s) { return s.part == next.part; });
        if (same == sets.end()) {
            sets.push_back(std::move(next));
            continue;
        }
        check_agreement(*same, next);
        if (std::any_of(same->inputs.begin(), same->inputs.end(), [&](const ScanInput& input) {
                return input.sha256 == next.inputs.front().sha256;
            })) {
            throw InputError(file.string(), "content", "the same as of a file before it",
                             "each scan once");
        }
        for (Scan& scan : next.scans) same->scans.push_back(std::move(scan));
        for (ScanInput& input : next.inputs) same->inputs.push_back(std::move(input));
        for (std::string& note : next.notes) same->notes.push_back(std::move(note));
    }
    std::sort(sets.begin(), sets.end(),
              [](const ScanSet& a, const ScanSet& b) { return a.part < b.part; });
    return sets;
}

std::string scans_to_text(const ScanSet& set) {
    if (set.scans.empty()) throw InputError("scans", "scans", "none", "at least one");
    const Scan& first = set.scans.front();
    for (const Scan& scan : set.scans) {
        if (scan.quantity != first.quantity ||
            scan.source_aperture_deg != first.source_aperture_deg ||
            scan.detector_aperture_deg != first.detector_aperture_deg ||
            scan.saturation != first.saturation || scan.sigma.empty() != first.sigma.empty()) {
            throw InputError("scans", "scans", "of different set-ups", "one set-up a file");
        }
    }
    std::string text = "# format: " + std::string(format_value) + "\n";
    const auto line = [&](std::string_view key, const std::string& value) {
        if (!value.empty()) text += "# " + std::string(key) + ": " + value + "\n";
    };
    std::string name = set.name;
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    line("name", name);
    line("part", std::string(scan_part_names[static_cast<std::size_t>(set.part)]));
    line("quantity", std::string(scan_quantity_names[static_cast<std::size_t>(first.quantity)]));
    line("calibration",
         std::string(scan_calibration_names[static_cast<std::size_t>(set.calibration)]));
    line("unit", set.unit);
    line("source_aperture_deg", format_number(first.source_aperture_deg));
    line("detector_aperture_deg", format_number(first.detector_aperture_deg));
    line("turn_sense", "counter-clockwise");
    line("metal", set.metal);
    line("light", set.light);
    if (std::isfinite(first.saturation)) line("saturation", format_number(first.saturation));
    text += "incidence_deg,receive_deg,turn_deg,azimuth_deg";
    for (const ScanChannel& channel : set.channels) text += "," + channel.name;
    if (!first.sigma.empty()) {
        for (const ScanChannel& channel : set.channels)
            text += ",sigma" + channel.name.substr(std::string_view("intensity").size());
    }
    text += '\n';
    const std::size_t channels = set.channels.size();
    const auto reading = [&](double value) {
        text += "," + (std::isnan(value) ? "" : format_number(value));
    };
    for (const Scan& scan : set.scans) {
        for (std::size_t i = 0; i < scan.rows.size(); ++i) {
            text += format_number(scan.incidence_deg) + "," +
                    format_number(scan.rows[i].receive_deg) + "," + format_number(scan.turn_deg) +
                    "," + format_number(scan.rows[i].azimuth_deg);
            for (std::size_t c = 0; c < channels; ++c) reading(scan.intensity[i * channels + c]);
            for (std::size_t c = 0; c < channels && !scan.sigma.empty(); ++c)
                reading(scan.sigma[i * channels + c]);
            text += '\n';
        }
    }
    return text;
}

}  // namespace togishi
