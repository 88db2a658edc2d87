#include "extperfc/translate/definition_store.hpp"
