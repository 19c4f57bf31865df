// The sum over all lamps, into `sum`. Included where the surface is known, behind three macros: TG_REACHED(towards) is 1
// where the lamp can be reflected, else 0; TG_REFLECT(towards, colour, row) is what is reflected of it; TG_SEEN(index, towards) is 0
// where something hides it, else 1. A loop of one
// turn stands where others would write `if`: some compilers turn a branch into two sides that are both computed.
    int first = 0;
#ifdef TG_POINTS
    int points = int(frame.counts.x);
    for (int i = 0; i < points; ++i) {
        Towards t = towards_point(i, place);
        int times = TG_REACHED(t);
        for (int once = 0; once < times; ++once) {
            sum += TG_REFLECT(t, point_colour(i, t), lamp_row(i)) * TG_SEEN(i, t);
        }
    }
    first += points;
#endif
#ifdef TG_SPOTS
    int spot_count = int(frame.counts.y);
    for (int i = 0; i < spot_count; ++i) {
        Towards t = towards_point(first + i, place);
        int times = TG_REACHED(t);
        for (int once = 0; once < times; ++once) {
            sum += TG_REFLECT(t, spot_colour(first + i, i, t), lamp_row(first + i)) * TG_SEEN(first + i, t);
        }
    }
    first += spot_count;
#endif
#ifdef TG_SUNS
    int suns = int(frame.counts.z);
    for (int i = 0; i < suns; ++i) {
        Towards t = towards_sun(first + i);
        int times = TG_REACHED(t);
        for (int once = 0; once < times; ++once) {
            sum += TG_REFLECT(t, sun_colour(first + i), lamp_row(first + i)) * TG_SEEN(first + i, t);
        }
    }
#endif
