#include "extperfc/translate/bridge.hpp"
