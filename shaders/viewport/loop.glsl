// The sum over all lamps of TG_REFLECT(arriving), into `sum`. Included where the surface is known.
    int first = 0;
#ifdef TG_POINTS
    int points = int(frame.counts.x);
    for (int i = 0; i < points; ++i) {
        sum += TG_REFLECT(arriving_point(i, place));
    }
    first += points;
#endif
#ifdef TG_SPOTS
    int spot_count = int(frame.counts.y);
    for (int i = 0; i < spot_count; ++i) {
        sum += TG_REFLECT(arriving_spot(first + i, i, place));
    }
    first += spot_count;
#endif
#ifdef TG_SUNS
    int suns = int(frame.counts.z);
    for (int i = 0; i < suns; ++i) {
        sum += TG_REFLECT(arriving_sun(first + i));
    }
#endif
