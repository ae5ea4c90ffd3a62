#pragma once

#include "veins_stub.hpp"
