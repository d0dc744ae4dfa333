/* A plugin of qemu: counts the instructions that are executed from the first one of one function to the first one of
   another, both left out, and prints the smallest, the mean and the largest number.

     qemu-system-arm … -plugin libcount_instructions.so,begin=0x1a0,end=0x1a4 -d plugin

   The declarations are those of version 1 of qemu's interface for plugins. */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info_t qemu_info_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*translated)(qemu_plugin_id_t, struct qemu_plugin_tb*);
typedef void (*executed)(unsigned vcpu, void* data);
typedef void (*exited)(qemu_plugin_id_t, void* data);

size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb*, size_t);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn*);
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, translated);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn*, executed, int flags, void* data);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, exited, void* data);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

static uint64_t begin, end, count, total, runs, least = UINT64_MAX, most;
static int counting;

static void on_instruction(unsigned vcpu, void* address) {
  const uint64_t at = (uint64_t)(uintptr_t)address;
  (void)vcpu;
  if (at == begin) {
    counting = 1;
    count = 0;
  } else if (at == end && counting) {
    counting = 0;
    total += count;
    ++runs;
    if (count < least) least = count;
    if (count > most) most = count;
  } else if (counting) {
    ++count;
  }
}

static void on_translation(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); ++i) {
    struct qemu_plugin_insn* const instruction = qemu_plugin_tb_get_insn(block, i);
    qemu_plugin_register_vcpu_insn_exec_cb(instruction, on_instruction, 0,
                                           (void*)(uintptr_t)qemu_plugin_insn_vaddr(instruction));
  }
}

static void on_exit_of_qemu(qemu_plugin_id_t id, void* data) {
  (void)id;
  (void)data;
  fprintf(stderr, "instructions: runs %" PRIu64 ", least %" PRIu64 ", mean %.3f, most %" PRIu64 "\n", runs,
          runs > 0 ? least : 0, runs > 0 ? (double)total / (double)runs : 0.0, most);
}

__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int count_of,
                                                               char** arguments) {
  (void)info;
  for (int i = 0; i < count_of; ++i) {
    if (strncmp(arguments[i], "begin=", 6) == 0) begin = strtoull(arguments[i] + 6, NULL, 0);
    if (strncmp(arguments[i], "end=", 4) == 0) end = strtoull(arguments[i] + 4, NULL, 0);
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
  qemu_plugin_register_atexit_cb(id, on_exit_of_qemu, NULL);
  return 0;
}
