// Counts what a test program takes from the heap: linking palpate_allocation_count replaces its
// operators new. Under the thread sanitizer of clang what comes from malloc counts too.
#pragma once

namespace palpate {

// Number of calls of operator new so far, of all threads.
long AllocationCount() noexcept;
// Number of calls of the calling thread.
long OwnAllocationCount() noexcept;

}  // namespace palpate
