// SPDX-License-Identifier: Apache-2.0
// What test/reload.comp writes besides its push constant.
uint number() { return 1; }
