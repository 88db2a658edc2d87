#include "extperfc/translate/schema.hpp"
