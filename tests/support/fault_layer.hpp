// SPDX-License-Identifier: Apache-2.0
// The fault layer inside a test's own process: FaultLayer puts it between the process and its
// driver, arm() says which call fails from then on. Make one before the first device.
#pragma once

#include <dlfcn.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace ockham::test {

class FaultLayer {
public:
    FaultLayer() {
        ::setenv("VK_LAYER_PATH", OCKHAM_FAULT_LAYER ":/usr/share/vulkan/explicit_layer.d",
            1); // and validation
        ::setenv("VK_INSTANCE_LAYERS", "VK_LAYER_OCKHAM_fault", 1);
        library_ = ::dlopen(OCKHAM_FAULT_LAYER "/libockham_fault_layer.so", RTLD_NOW);
        if (!library_) throw std::runtime_error(::dlerror());
        arm_ = reinterpret_cast<void (*)(const char*)>(::dlsym(library_, "arm_fault"));
        hit_ = reinterpret_cast<int (*)()>(::dlsym(library_, "fault_hit"));
    }
    ~FaultLayer() {
        ::unsetenv("VK_INSTANCE_LAYERS");
        ::unsetenv("VK_LAYER_PATH");
        ::dlclose(library_);
    }
    FaultLayer(const FaultLayer&) = delete;
    FaultLayer& operator=(const FaultLayer&) = delete;

    /// "name:n:result": the n-th call of `name` from now on returns `result`; "": none.
    void arm(const std::string& fault) const { arm_(fault.c_str()); }
    /// The armed call has failed.
    bool hit() const { return hit_() != 0; }

private:
    void* library_ = nullptr;
    void (*arm_)(const char*) = nullptr;
    int (*hit_)() = nullptr;
};

} // namespace ockham::test
