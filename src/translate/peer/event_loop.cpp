#include "extperfc/translate/event_loop.hpp"
