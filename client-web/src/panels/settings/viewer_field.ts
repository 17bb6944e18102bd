// A row of the server's table as the control that sets it for the viewer, in whichever panel it stands.

import type { SettingRow } from '../../wire/protocol.js';
import type { Viewer } from '../../viewer.js';
import { SettingField, type ControlMaker } from './settings_field.js';

/** Another panel that has rows of the server's table, and none of them stands twice. */
export interface OtherPanel {
  readonly title: string;
  has(row: SettingRow): boolean;
  /** Opens the panel with the focus at this setting. */
  open(name: string): void;
}

/** What leads to a row that stands in another panel. */
export const elsewhere = ({ title }: OtherPanel, { label }: SettingRow): string => `${label}: in the panel ${title}`;

/** `refresh` shows what was typed and is no value; `describedBy`: the id of what is said of the row beside it. */
export function viewerField(
  viewer: Viewer,
  row: SettingRow,
  refresh: () => void,
  make?: ControlMaker,
  describedBy = '',
): SettingField {
  const hooks = {
    changed: (value: SettingRow['default']) => viewer.setSettings({ [row.name]: value }),
    preset: () => viewer.settings.default(row),
    invalid: (message: string) => {
      viewer.settings.reject(row.name, message);
      refresh();
    },
    describedBy,
  };
  return new SettingField(row, hooks, make);
}

/** Its value, what the server said of it, and whether this viewer may change it. */
export function showField({ settings, watching }: Viewer, row: SettingRow, field: SettingField): void {
  const value = settings.value(row.name);
  if (value === undefined) return;
  field.show(value, settings.isDefault(row));
  field.setError(settings.error(row.name));
  field.setDisabled(!watching.maySet([row.name]));
}
