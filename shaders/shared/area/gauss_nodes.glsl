// Gauss-Legendre quadrature on [-1, 1].

// The non-negative halves of the rules of 1, 2, 3, 4, 6, 8, 12 and 16 nodes, one after the other.
const float TG_GAUSS_POSITION[27] = {
    float(0.0), float(0.577350269189625765), float(0.0),
    float(0.774596669241483377), float(0.339981043584856265), float(0.861136311594052575),
    float(0.238619186083196909), float(0.661209386466264514), float(0.932469514203152028),
    float(0.183434642495649805), float(0.525532409916328986), float(0.79666647741362674),
    float(0.960289856497536232), float(0.125233408511468915), float(0.367831498998180194),
    float(0.587317954286617447), float(0.769902674194304687), float(0.904117256370474857),
    float(0.981560634246719251), float(0.09501250983763744), float(0.281603550779258913),
    float(0.458016777657227386), float(0.617876244402643748), float(0.755404408355003034),
    float(0.865631202387831744), float(0.944575023073232576), float(0.989400934991649933)
};
const float TG_GAUSS_WEIGHT[27] = {
    float(2.0), float(1.0), float(0.888888888888888889),
    float(0.555555555555555556), float(0.652145154862546143), float(0.347854845137453857),
    float(0.467913934572691047), float(0.360761573048138608), float(0.171324492379170345),
    float(0.362683783378361983), float(0.313706645877887287), float(0.222381034453374471),
    float(0.101228536290376259), float(0.249147045813402785), float(0.233492536538354809),
    float(0.203167426723065922), float(0.160078328543346226), float(0.106939325995318431),
    float(0.047175336386511827), float(0.189450610455068496), float(0.182603415044923589),
    float(0.169156519395002538), float(0.149595988816576732), float(0.124628971255533872),
    float(0.095158511682492785), float(0.062253523938647893), float(0.027152459411754095)
};

// Node k of count as (position, weight); the weights add up to 2. count: one of the above, or a multiple of 16, which is
// then so many rules of 16 side by side.
TG_FN vec2 gauss_node(int count, int k) {
    int panels = count > 16 ? count / 16 : 1;
    int size = count > 16 ? 16 : count;
    int index = k % size;
    int first = size < 4 ? (size < 3 ? size - 1 : 2) : size < 8 ? (size < 6 ? 4 : 6) : size < 12 ? 9 : size < 16 ? 13 : 19;
    int from_middle = index - size / 2;
    bool upper = from_middle >= 0;
    int entry = upper ? from_middle : (size - 1 - index) - size / 2;
    float x = TG_GAUSS_POSITION[first + entry];
    float w = TG_GAUSS_WEIGHT[first + entry];
    x = upper ? x : -x;
    float share = float(1.0) / float(panels);
    return vec2(x * share + (float(2.0) * float(k / size) + float(1.0)) * share - float(1.0), w * share);
}
