// A lobe as wide as the texels of a normal map in the pixel make it (TG_NORMAL_MAP).
#include "shared/area/gaussian_part.glsl"
#include "shared/area/lobe_filter.glsl"

LobeForm spread_lobe(LobeForm form, SteelPixel p) {
    return lobe_form_widened(form, p.spread_a, p.spread_b, 1.0);
}

// A measured weight is the lobe's own peak and sinks as it widens; a normalised one (negative) stays one.
float spread_weight(float own_weight, LobeForm own, LobeForm wide) {
    return own_weight * wide.scale / own.scale;
}
