// The dimensions that a katana is generated from, as sword registers give them (docs/blade.md
// defines each).
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace togishi {

enum class Zukuri { shinogi, hira, shobu };
enum class SoriType { koshi, torii, saki, even };
enum class MuneType { iori, mitsu, maru, kaku };
enum class Jiri { kuri, haagari, kiri };

struct KatanaParameters {
    Zukuri zukuri = Zukuri::shinogi;
    SoriType sori_type = SoriType::torii;
    MuneType mune = MuneType::iori;
    Jiri nakago_jiri = Jiri::kuri;
    double nagasa_mm = 736;      ///< straight line from the mune-machi to the tip
    double sori_mm = 18;         ///< greatest distance of that line to the mune
    double motohaba_mm = 31;     ///< width at the machi, mune ridge to edge
    double sakihaba_mm = 20;     ///< width at the yokote (where the fukura starts if there is none)
    double motokasane_mm = 6.8;  ///< thickness at the mune's corners, at the machi
    double sakikasane_mm = 4.3;  ///< the same at the yokote
    double kissaki_mm = 33;      ///< straight line from the yokote on the mune to the tip
    double fukura = 1;           ///< roundness of the point's edge: 0 karetaru, 1 full
    double mune_height_mm = 1.5;         ///< height of the mune over its corners at the machi
    double moto_shinogi_haba_mm = 10.5;  ///< mune ridge to shinogi at the machi
    double saki_shinogi_haba_mm = 7.4;   ///< the same at the yokote
    double shinogi_rise_mm =
        0.45;               ///< how far each shinogi stands out over the mune's corner at the machi
    double niku_mm = 0.25;  ///< bulge of the ji over the flat at the machi
    double ha_haba_mm = 8.5;  ///< width of the nominal suguha at the machi (parts "ha" and "boshi")
    double nakago_mm = 212;   ///< straight line from the mune-machi to the nakago's end
    double nakago_sakihaba_mm = 17;        ///< width of the nakago where its end starts to round
    double nakago_sakikasane_mm = 4.8;     ///< its thickness there
    double ha_machi_mm = 3;                ///< depth of the notch on the edge side
    double mune_machi_mm = 2.2;            ///< depth of the notch on the back
    double mekugi_ana_mm = 6.5;            ///< diameter of the peg hole; 0: none
    double mekugi_ana_from_machi_mm = 70;  ///< from the machi to the hole's centre
};

/// One numeric dimension: its key, what it is, unit and the range that any blade's must lie in.
struct DimensionField {
    std::string_view key;
    std::string_view help;
    std::string_view unit;  ///< "mm", or "" for a ratio
    double KatanaParameters::*member;
    double min;
    double max;
};
/// One choice: its key and the names allowed, in the order of the enum.
struct ChoiceField {
    std::string_view key;
    std::string_view help;
    std::vector<std::string_view> names;
    int (*get)(const KatanaParameters&);
    void (*set)(KatanaParameters&, int);
};

std::span<const DimensionField> katana_dimensions();
std::span<const ChoiceField> katana_choices();

/// Ordinary dimensions of a blade of this zukuri. Throws InputError for another name.
KatanaParameters katana_defaults(std::string_view zukuri = "shinogi");

/// Sets one value by its key. `where` names the source in errors. Throws InputError for unknown
/// keys and names.
void set_katana_value(KatanaParameters& parameters, std::string_view key, double value,
                      std::string_view where);
void set_katana_value(KatanaParameters& parameters, std::string_view key, std::string_view name,
                      std::string_view where);

/// Throws InputError naming the first dimension that no blade could have, and why.
void check_katana(const KatanaParameters& parameters, std::string_view where);

}  // namespace togishi
