// Counts what a test program takes from the heap: links in operators new of its own.
#pragma once

namespace palpate {

// How often operator new was called so far.
long Allocations();

}  // namespace palpate
