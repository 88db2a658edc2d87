#include "extperfc/translate/peer.hpp"
