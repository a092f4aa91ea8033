// Counts every allocation of the test program through the global operator new.
#pragma once

namespace palpate {

int AllocationCount();

}  // namespace palpate
