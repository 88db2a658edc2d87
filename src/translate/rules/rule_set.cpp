#include "extperfc/translate/rules.hpp"
