// SPDX-License-Identifier: Apache-2.0
// A Vulkan layer that lets calls fail, to walk the paths that a healthy driver never takes. Not a
// part of the framework; the loader puts it between a program and its driver:
//   VK_LAYER_PATH=<folder of its manifest> VK_INSTANCE_LAYERS=VK_LAYER_OCKHAM_fault
//   OCKHAM_FAULT=vkAllocateMemory:3:-2   the third call returns VK_ERROR_OUT_OF_DEVICE_MEMORY
//   OCKHAM_FAULT_LOG=file                at the end: a line "name calls" of each entry point, "hit"
// Once -4 (device lost) was returned, submissions and waits go on returning it, as drivers do, until
// another device is made.
// arm_fault() does the same from inside a process. One driver at a time.
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

// Every entry point that the framework calls and that can fail.
#define OCKHAM_INSTANCE_CALLS(X)                                                                   \
    X(EnumeratePhysicalDevices) X(GetPhysicalDeviceImageFormatProperties2)
#define OCKHAM_DEVICE_CALLS(X)                                                                     \
    X(AllocateCommandBuffers)                                                                      \
    X(AllocateDescriptorSets)                                                                      \
    X(AllocateMemory)                                                                              \
    X(BeginCommandBuffer)                                                                          \
    X(BindBufferMemory)                                                                            \
    X(BindImageMemory)                                                                             \
    X(CreateBuffer)                                                                                \
    X(CreateCommandPool)                                                                           \
    X(CreateComputePipelines)                                                                      \
    X(CreateDescriptorPool)                                                                        \
    X(CreateDescriptorSetLayout)                                                                   \
    X(CreateFence)                                                                                 \
    X(CreateFramebuffer)                                                                           \
    X(CreateGraphicsPipelines)                                                                     \
    X(CreateImage)                                                                                 \
    X(CreateImageView)                                                                             \
    X(CreatePipelineCache)                                                                         \
    X(CreatePipelineLayout)                                                                        \
    X(CreateQueryPool)                                                                             \
    X(CreateRenderPass)                                                                            \
    X(CreateSampler)                                                                               \
    X(CreateSemaphore)                                                                             \
    X(CreateShaderModule)                                                                          \
    X(DeviceWaitIdle)                                                                              \
    X(EndCommandBuffer)                                                                            \
    X(GetPipelineCacheData)                                                                        \
    X(GetQueryPoolResults)                                                                         \
    X(MapMemory)                                                                                   \
    X(QueueSubmit)                                                                                 \
    X(QueueSubmit2)                                                                                \
    X(ResetCommandPool)                                                                            \
    X(ResetDescriptorPool)                                                                         \
    X(ResetFences)                                                                                 \
    X(WaitForFences)                                                                               \
    X(WaitSemaphores)

namespace {

enum Call : std::size_t {
#define OCKHAM_ENUM(name) k##name,
    OCKHAM_ENUM(CreateInstance) OCKHAM_ENUM(CreateDevice) OCKHAM_INSTANCE_CALLS(OCKHAM_ENUM)
        OCKHAM_DEVICE_CALLS(OCKHAM_ENUM) kCalls
#undef OCKHAM_ENUM
};

constexpr std::array<const char*, kCalls> kNames = {
#define OCKHAM_NAME(name) "vk" #name,
    OCKHAM_NAME(CreateInstance) OCKHAM_NAME(CreateDevice) OCKHAM_INSTANCE_CALLS(OCKHAM_NAME)
        OCKHAM_DEVICE_CALLS(OCKHAM_NAME)
#undef OCKHAM_NAME
};

/// Which call fails, and what was called so far.
class Plan {
public:
    Plan() {
        if (const char* fault = std::getenv("OCKHAM_FAULT")) arm(fault);
    }
    ~Plan() {
        const char* path = std::getenv("OCKHAM_FAULT_LOG");
        std::FILE* file = path ? std::fopen(path, "a") : nullptr;
        if (!file) return;
        for (std::size_t i = 0; i < kCalls; ++i) {
            if (counts_[i] > 0) std::fprintf(file, "%s %u\n", kNames[i], counts_[i]);
        }
        if (hit_) std::fputs("hit\n", file);
        std::fclose(file);
    }

    /// "name:n:result"; counting begins anew, and a lost device is forgotten. Empty: none fails.
    void arm(std::string_view fault) {
        const std::lock_guard lock(mutex_);
        counts_.fill(0);
        lost_ = hit_ = false;
        at_ = 0;
        const std::size_t colon = fault.find(':');
        const std::string name(fault.substr(0, colon));
        for (std::size_t i = 0; i < kCalls && colon != std::string_view::npos; ++i) {
            if (name != kNames[i]) continue;
            call_ = i;
            int result = 0;
            const std::string rest(fault.substr(colon + 1));
            if (std::sscanf(rest.c_str(), "%u:%d", &at_, &result) != 2) at_ = 0;
            result_ = static_cast<VkResult>(result);
        }
        if (!fault.empty() && at_ == 0) {
            std::fprintf(stderr, "OCKHAM_FAULT: '%s' is no fault\n", name.c_str());
            std::abort();
        }
    }

    bool hit() {
        const std::lock_guard lock(mutex_);
        return hit_;
    }

    /// A lost device does not come back; another one works.
    void device_created() {
        const std::lock_guard lock(mutex_);
        lost_ = false;
    }

    /// What this call returns instead of being made.
    std::optional<VkResult> fault(std::size_t call) {
        const std::lock_guard lock(mutex_);
        ++counts_[call];
        if (at_ > 0 && call == call_ && counts_[call] == at_) {
            hit_ = true;
            ::unsetenv("OCKHAM_FAULT"); // the layer may be loaded again, with another instance
            lost_ = result_ == VK_ERROR_DEVICE_LOST;
            return result_;
        }
        const bool waits = call == kQueueSubmit || call == kQueueSubmit2 ||
                           call == kWaitForFences || call == kWaitSemaphores ||
                           call == kDeviceWaitIdle || call == kGetQueryPoolResults;
        if (lost_ && waits) return VK_ERROR_DEVICE_LOST;
        return {};
    }

private:
    std::mutex mutex_;
    std::array<unsigned, kCalls> counts_{};
    std::size_t call_ = 0;
    unsigned at_ = 0; ///< the call that fails, from 1; 0: none
    VkResult result_ = VK_SUCCESS;
    bool lost_ = false, hit_ = false;
};

Plan& plan() {
    static Plan instance;
    return instance;
}

VkDevice latest_device = VK_NULL_HANDLE;

/// On a lost device nothing is under way any more.
void finish_work();

/// A wrapper of one entry point; `next`: the driver's, or the next layer's.
template <std::size_t call, class Function>
struct Wrapped;
template <std::size_t call, class... Args>
struct Wrapped<call, VkResult(VKAPI_PTR*)(Args...)> {
    static inline std::atomic<VkResult(VKAPI_PTR*)(Args...)> next{nullptr};
    static VKAPI_ATTR VkResult VKAPI_CALL function(Args... args) {
        if (const std::optional<VkResult> fault = plan().fault(call)) {
            if (*fault == VK_ERROR_DEVICE_LOST) finish_work();
            return *fault;
        }
        return next.load()(args...);
    }
};

void finish_work() {
    if (const auto wait = Wrapped<kDeviceWaitIdle, PFN_vkDeviceWaitIdle>::next.load())
        wait(latest_device);
}

PFN_vkGetInstanceProcAddr next_instance_proc = nullptr;
PFN_vkGetDeviceProcAddr next_device_proc = nullptr;

/// The link that the loader hangs into a creation, moved on for the layer below.
template <class Link, class Info>
Link* take_link(const Info* info, VkStructureType type) {
    for (auto* next = static_cast<Link*>(const_cast<void*>(info->pNext)); next != nullptr;
         next = static_cast<Link*>(const_cast<void*>(next->pNext))) {
        if (next->sType == type && next->function == VK_LAYER_LINK_INFO) return next;
    }
    return nullptr;
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info,
    const VkAllocationCallbacks* allocator, VkInstance* instance) {
    auto* link =
        take_link<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    if (const std::optional<VkResult> fault = plan().fault(kCreateInstance)) return *fault;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(
        next_instance_proc(VK_NULL_HANDLE, "vkCreateInstance"));
    const VkResult result = create(info, allocator, instance);
    if (result != VK_SUCCESS) return result;
#define OCKHAM_NEXT(name)                                                                          \
    Wrapped<k##name, PFN_vk##name>::next =                                                         \
        reinterpret_cast<PFN_vk##name>(next_instance_proc(*instance, "vk" #name));
    OCKHAM_INSTANCE_CALLS(OCKHAM_NEXT)
#undef OCKHAM_NEXT
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical,
    const VkDeviceCreateInfo* info, const VkAllocationCallbacks* allocator, VkDevice* device) {
    auto* link =
        take_link<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const PFN_vkGetInstanceProcAddr instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    next_device_proc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    if (const std::optional<VkResult> fault = plan().fault(kCreateDevice)) return *fault;
    const auto create =
        reinterpret_cast<PFN_vkCreateDevice>(instance_proc(VK_NULL_HANDLE, "vkCreateDevice"));
    const VkResult result = create(physical, info, allocator, device);
    if (result != VK_SUCCESS) return result;
#define OCKHAM_NEXT(name)                                                                          \
    Wrapped<k##name, PFN_vk##name>::next =                                                         \
        reinterpret_cast<PFN_vk##name>(next_device_proc(*device, "vk" #name));
    OCKHAM_DEVICE_CALLS(OCKHAM_NEXT)
#undef OCKHAM_NEXT
    latest_device = *device;
    plan().device_created();
    return result;
}

PFN_vkVoidFunction own_function(const char* name) {
    if (std::strcmp(name, "vkCreateInstance") == 0)
        return reinterpret_cast<PFN_vkVoidFunction>(create_instance);
    if (std::strcmp(name, "vkCreateDevice") == 0)
        return reinterpret_cast<PFN_vkVoidFunction>(create_device);
#define OCKHAM_OWN(call)                                                                           \
    if (std::strcmp(name, "vk" #call) == 0)                                                        \
        return reinterpret_cast<PFN_vkVoidFunction>(Wrapped<k##call, PFN_vk##call>::function);
    OCKHAM_INSTANCE_CALLS(OCKHAM_OWN)
    OCKHAM_DEVICE_CALLS(OCKHAM_OWN)
#undef OCKHAM_OWN
    return nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_proc(VkDevice device, const char* name) {
    if (const PFN_vkVoidFunction own = own_function(name)) return own;
    return next_device_proc(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_proc(VkInstance instance, const char* name) {
    if (std::strcmp(name, "vkGetInstanceProcAddr") == 0)
        return reinterpret_cast<PFN_vkVoidFunction>(instance_proc);
    if (std::strcmp(name, "vkGetDeviceProcAddr") == 0)
        return reinterpret_cast<PFN_vkVoidFunction>(device_proc);
    if (const PFN_vkVoidFunction own = own_function(name)) return own;
    return next_instance_proc ? next_instance_proc(instance, name) : nullptr;
}

} // namespace

extern "C" {

VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(
    VkNegotiateLayerInterface* version) {
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = instance_proc;
    version->pfnGetDeviceProcAddr = device_proc;
    version->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}

/// For tests that load this library themselves: as OCKHAM_FAULT, counted from now on.
void arm_fault(const char* fault) { plan().arm(fault); }
/// Whether the armed call has failed.
int fault_hit() { return plan().hit() ? 1 : 0; }
}
