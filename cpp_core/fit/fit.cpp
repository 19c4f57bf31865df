#include "fit/fit.hpp"
