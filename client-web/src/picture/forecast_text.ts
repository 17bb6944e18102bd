// What the page says of how the picture's error goes on. Knows no DOM.

import type { Forecast } from '../wire/protocol.js';
import { waitText } from './time_left.js';

/** An error that was asked for, without digits that say nothing: "1 %", "0.5 %". */
export const roundPercent = (share: number): string => `${Number((share * 100).toPrecision(2))} %`;

/**
 * "2 % in 4 s · 1 % in 16 s", of what the samples asked for suffice for; else what the next step would take. '' where nothing is
 * known. `refining`: samples are still added. `targetSamples` 0: not known.
 */
export function forecastText(forecast: Forecast | null, refining: boolean, targetSamples: number): string {
  if (forecast === null) return '';
  if (forecast.plateau) return refining ? 'more samples have not helped lately' : '';
  const within = forecast.steps.filter(({ samples, seconds }) => seconds !== null && (targetSamples === 0 || samples <= targetSamples));
  if (refining && within.length > 0) {
    return within
      .slice(0, 2)
      .map(({ error, seconds }) => `${roundPercent(error)} in ${waitText(seconds! * 1000)}`)
      .join(' · ');
  }
  const next = forecast.steps.find(({ samples }) => targetSamples > 0 && samples > targetSamples);
  if (next === undefined) return '';
  return `${roundPercent(next.error)} would take ${samplesText(next.samples)} samples`;
}

/** " · refining 34 % of it": which part of a picture with an error target still gets samples. '' for all and for none. */
export function refinedText(final: boolean, refined: number): string {
  return final || refined <= 0 || refined >= 1 ? '' : ` · refining ${Math.max(1, Math.round(refined * 100))} % of it`;
}

/** Two digits: more would pretend. */
function samplesText(samples: number): string {
  const rounded = Number(samples.toPrecision(2));
  return rounded.toString().replace(/\B(?=(\d{3})+$)/g, '\u202f');
}
