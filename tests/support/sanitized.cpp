// SPDX-License-Identifier: Apache-2.0
// What sanitizers need to know of libraries that are not instrumented: the Vulkan driver, its
// layers, and TBB.
// Linked into tests and programs that are built with one (cmake/Sanitizers.cmake), into nothing
// else.
#include <dlfcn.h>

#if defined(__SANITIZE_ADDRESS__)
namespace {
/// Keeps driver and layer in memory, so that a report of leaks can tell their frames from ours.
[[maybe_unused]] void* const driver = dlopen("libvulkan_lvp.so", RTLD_LAZY | RTLD_NODELETE);
[[maybe_unused]] void* const layer =
    dlopen("libVkLayer_khronos_validation.so", RTLD_LAZY | RTLD_NODELETE);
} // namespace

/// Loader, layer and driver keep what is theirs. Of ours, a frame of this program would be seen.
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libVkLayer_khronos_validation\nleak:libvulkan\n";
}
#elif defined(__SANITIZE_THREAD__)
/// The validation layer watches queues on a thread of its own, and lavapipe's threads leave fences
/// while others destroy them; OpenVDB hands its work to the threads of TBB, which nothing else
/// uses. How they agree on that is not seen.
extern "C" const char* __tsan_default_suppressions() {
    return "race:libVkLayer_khronos_validation\ndeadlock:libVkLayer_khronos_validation\n"
           "race:libvulkan_lvp\nrace:tbb::detail\n";
}
/// OpenVDB starts threads in a process that was forked to read one file.
extern "C" const char* __tsan_default_options() { return "die_after_fork=0"; }
#endif
