#include "extperfc/translate/plan.hpp"
