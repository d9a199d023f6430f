/* The least of Vulkan that a lookup by a compute shader needs: a device, storage buffers that the program sees, a pipeline with two
 * specialization constants and two push constants. An engine has all of this.
 *
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>

#include <vulkan/vulkan.h>

#define INFO(name) .sType = VK_STRUCTURE_TYPE_##name

enum { GROUP = 64, BUFFERS = 4 }; /* GROUP: local_size_x of the shader; BUFFERS: bindings 0 to 3 */

typedef struct gpu {
    VkPhysicalDevice physical;
    VkDevice         device;
    VkQueue          queue;
    VkCommandBuffer  commands;
    VkBuffer         buffer[BUFFERS];
    void            *mapped[BUFFERS];
    VkPipeline       pipeline;
    VkPipelineLayout layout;
    VkDescriptorSet  set;
} gpu;

static void check(int ok, const char *what)
{
    if (ok) return;
    fprintf(stderr, "vulkan: %s\n", what);
    exit(1);
}

static void open_gpu(gpu *g)
{
    VkInstance              instance;
    VkCommandPool           pool;
    VkQueueFamilyProperties families[16];
    uint32_t                count = 1, family_count = 16, family = 0;
    VkInstanceCreateInfo    program = {INFO(INSTANCE_CREATE_INFO)};
    check(!vkCreateInstance(&program, NULL, &instance), "no Vulkan driver");
    check(vkEnumeratePhysicalDevices(instance, &count, &g->physical) >= 0 && count, "no device");
    vkGetPhysicalDeviceQueueFamilyProperties(g->physical, &family_count, families);
    while (family < family_count && !(families[family].queueFlags & VK_QUEUE_COMPUTE_BIT)) family++;
    check(family < family_count, "the device has no compute queue");

    VkDeviceQueueCreateInfo queue  = {INFO(DEVICE_QUEUE_CREATE_INFO), .queueFamilyIndex = family, .queueCount = 1,
                                      .pQueuePriorities = &(float){1}};
    VkDeviceCreateInfo      device = {INFO(DEVICE_CREATE_INFO), .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
    check(!vkCreateDevice(g->physical, &device, NULL, &g->device), "the device cannot be used");
    vkGetDeviceQueue(g->device, family, 0, &g->queue);
    VkCommandPoolCreateInfo commands = {INFO(COMMAND_POOL_CREATE_INFO), .queueFamilyIndex = family};
    commands.flags                   = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    check(!vkCreateCommandPool(g->device, &commands, NULL, &pool), "out of memory");
    VkCommandBufferAllocateInfo buffer = {INFO(COMMAND_BUFFER_ALLOCATE_INFO), .commandPool = pool, .commandBufferCount = 1};
    check(!vkAllocateCommandBuffers(g->device, &buffer, &g->commands), "out of memory");
}

/* A storage buffer in memory that the program sees. An engine copies the words to memory of the device alone. */
static void *make_buffer(gpu *g, int n, VkDeviceSize bytes)
{
    VkPhysicalDeviceProperties       device;
    VkPhysicalDeviceMemoryProperties types;
    VkMemoryRequirements             needs;
    VkDeviceMemory                   memory;
    uint32_t                         type = 0, seen = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkBufferCreateInfo buffer = {INFO(BUFFER_CREATE_INFO), .size = bytes, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    vkGetPhysicalDeviceProperties(g->physical, &device);
    check(bytes <= device.limits.maxStorageBufferRange, "the words are larger than a storage buffer of this device may be");
    check(!vkCreateBuffer(g->device, &buffer, NULL, &g->buffer[n]), "out of memory");
    vkGetBufferMemoryRequirements(g->device, g->buffer[n], &needs);
    vkGetPhysicalDeviceMemoryProperties(g->physical, &types);
    while (!(needs.memoryTypeBits >> type & 1) || (types.memoryTypes[type].propertyFlags & seen) != seen) type++; /* there is one */
    VkMemoryAllocateInfo wanted = {INFO(MEMORY_ALLOCATE_INFO), .allocationSize = needs.size, .memoryTypeIndex = type};
    check(!vkAllocateMemory(g->device, &wanted, NULL, &memory), "out of memory");
    check(!vkBindBufferMemory(g->device, g->buffer[n], memory, 0), "out of memory");
    check(!vkMapMemory(g->device, memory, 0, VK_WHOLE_SIZE, 0, &g->mapped[n]), "out of memory");
    return g->mapped[n];
}

/* path  a file of SPIR-V, whose constants 0 and 1 are set;   the buffers 0 to 3 are there */
static void make_pipeline(gpu *g, const char *path, int32_t width_px, int32_t is_smooth)
{
    static uint32_t          text[1 << 18];
    FILE                    *file   = fopen(path, "rb");
    VkShaderModuleCreateInfo module = {INFO(SHADER_MODULE_CREATE_INFO), .pCode = text};
    VkShaderModule           shader;
    module.codeSize = file ? fread(text, 1, sizeof text, file) : 0;
    if (file) fclose(file);
    check(module.codeSize > 20 && module.codeSize < sizeof text && text[0] == 0x07230203, "the second argument is no SPIR-V file");
    check(!vkCreateShaderModule(g->device, &module, NULL, &shader), "the shader is not valid");

    VkDescriptorSetLayoutBinding bindings[BUFFERS];
    VkDescriptorSetLayout        set;
    for (uint32_t n = 0; n < BUFFERS; n++)
        bindings[n] = (VkDescriptorSetLayoutBinding){n, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    VkDescriptorSetLayoutCreateInfo buffers = {INFO(DESCRIPTOR_SET_LAYOUT_CREATE_INFO), .bindingCount = BUFFERS,
                                               .pBindings = bindings};
    check(!vkCreateDescriptorSetLayout(g->device, &buffers, NULL, &set), "out of memory");
    VkPushConstantRange        range  = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 8};
    VkPipelineLayoutCreateInfo layout = {INFO(PIPELINE_LAYOUT_CREATE_INFO), .setLayoutCount = 1, .pSetLayouts = &set};
    layout.pushConstantRangeCount     = 1;
    layout.pPushConstantRanges        = &range;
    check(!vkCreatePipelineLayout(g->device, &layout, NULL, &g->layout), "out of memory");

    const int32_t               filter[2] = {width_px, is_smooth};
    VkSpecializationMapEntry    ids[2]    = {{0, 0, 4}, {1, 4, 4}}; /* constant_id 0 and 1 of the shader */
    VkSpecializationInfo        constants = {2, ids, sizeof filter, filter};
    VkComputePipelineCreateInfo pipeline  = {INFO(COMPUTE_PIPELINE_CREATE_INFO), .layout = g->layout};
    pipeline.stage       = (VkPipelineShaderStageCreateInfo){INFO(PIPELINE_SHADER_STAGE_CREATE_INFO), .module = shader};
    pipeline.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    pipeline.stage.pName = "main";
    pipeline.stage.pSpecializationInfo = &constants;
    check(!vkCreateComputePipelines(g->device, VK_NULL_HANDLE, 1, &pipeline, NULL, &g->pipeline), "the shader cannot be compiled");

    VkDescriptorPool           pool;
    VkDescriptorPoolSize       size = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BUFFERS};
    VkDescriptorPoolCreateInfo sets = {INFO(DESCRIPTOR_POOL_CREATE_INFO), .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size};
    check(!vkCreateDescriptorPool(g->device, &sets, NULL, &pool), "out of memory");
    VkDescriptorSetAllocateInfo one = {INFO(DESCRIPTOR_SET_ALLOCATE_INFO), .descriptorPool = pool, .descriptorSetCount = 1};
    one.pSetLayouts                 = &set;
    check(!vkAllocateDescriptorSets(g->device, &one, &g->set), "out of memory");
    for (uint32_t n = 0; n < BUFFERS; n++) {
        VkDescriptorBufferInfo buffer = {g->buffer[n], 0, VK_WHOLE_SIZE};
        VkWriteDescriptorSet   write  = {INFO(WRITE_DESCRIPTOR_SET), .dstSet = g->set, .dstBinding = n, .descriptorCount = 1};
        write.descriptorType          = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        write.pBufferInfo             = &buffer;
        vkUpdateDescriptorSets(g->device, 1, &write, 0, NULL);
    }
}

/* Looks up the first points of the buffer, and waits for the answers. */
static void look_up(const gpu *g, uint32_t light, uint32_t points)
{
    const uint32_t           constants[2] = {light, points};
    VkCommandBufferBeginInfo begin        = {INFO(COMMAND_BUFFER_BEGIN_INFO)};
    VkMemoryBarrier          answers      = {INFO(MEMORY_BARRIER), NULL, VK_ACCESS_SHADER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
    VkSubmitInfo             submit       = {INFO(SUBMIT_INFO), .commandBufferCount = 1, .pCommandBuffers = &g->commands};
    check(!vkBeginCommandBuffer(g->commands, &begin), "out of memory");
    vkCmdBindPipeline(g->commands, VK_PIPELINE_BIND_POINT_COMPUTE, g->pipeline);
    vkCmdBindDescriptorSets(g->commands, VK_PIPELINE_BIND_POINT_COMPUTE, g->layout, 0, 1, &g->set, 0, NULL);
    vkCmdPushConstants(g->commands, g->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, constants);
    vkCmdDispatch(g->commands, (points + GROUP - 1) / GROUP, 1, 1);
    vkCmdPipelineBarrier(g->commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &answers, 0, NULL, 0,
                         NULL);
    check(!vkEndCommandBuffer(g->commands), "out of memory");
    check(!vkQueueSubmit(g->queue, 1, &submit, VK_NULL_HANDLE) && !vkQueueWaitIdle(g->queue), "the device is lost");
}
