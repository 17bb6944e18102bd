// Which of the settings of the hybrid device count for nothing at the moment.

import type { SettingRow, SettingValue } from '../../wire/protocol.js';

const ONLY_HYBRID = 'Only with device hybrid.';

/** Why the setting changes nothing with the present values; null when it does. */
export function withoutUse(
  { name, group }: Pick<SettingRow, 'name' | 'group'>,
  value: (name: string) => SettingValue | undefined,
): string | null {
  if (group !== 'hybrid' || name === 'showPartition') return null;
  if (value('device') !== 'hybrid') return ONLY_HYBRID;
  if (name === 'hybridShare' && value('hybridBalance') !== 'manual') return 'Only with a manual balance.';
  return null;
}
