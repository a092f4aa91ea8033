// Counts what a test program takes from the heap: linking palpate_allocation_count replaces its
// operators new. Under the thread sanitizer of clang what comes from malloc counts too.
#pragma once

namespace palpate {

// How often operator new was called so far, all threads together.
long AllocationCount() noexcept;
// The same of the calling thread alone.
long OwnAllocationCount() noexcept;

}  // namespace palpate
